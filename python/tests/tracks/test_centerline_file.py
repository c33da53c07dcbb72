"""Centerlines as CSV files: all published formats, and invalid files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

import firstlap
from firstlap.common.errors import InputError
from firstlap.tracks.centerline_file import load_centerline, parse_centerline

MAPS = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "maps"
ANGLE = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
RIGHT, LEFT = 1.2, 0.8
RING = np.column_stack([6.0 * np.cos(ANGLE), 6.0 * np.sin(ANGLE), 0 * ANGLE + RIGHT, 0 * ANGLE + LEFT])
"""A circle of 6 m radius, counterclockwise from (6, 0): the right wall is the outer one, at 7.2 m radius."""
F1TENTH = "# x_m, y_m, w_tr_right_m, w_tr_left_m"


def csv(rows: np.ndarray = RING, separator: str = ",", header: str = "") -> str:
    lines = [separator.join(f"{value:.6f}" for value in row) for row in rows]
    return "\n".join([header, *lines] if header else lines) + "\n"


def is_the_ring(text: str) -> firstlap.Track:
    track = parse_centerline(text, "ring.csv")
    outer, inner = (shapely.Polygon(wall).area for wall in (track.walls[1], track.walls[0]))
    assert track.sides == ["left", "right"]
    assert outer == pytest.approx(np.pi * 7.2**2, rel=0.01)
    assert inner == pytest.approx(np.pi * 5.2**2, rel=0.01)
    x, y, yaw = track.start_pose()
    assert np.hypot(x - 6.2, y) < 0.15
    assert yaw == pytest.approx(0.5 * np.pi, abs=0.05)
    return track


@pytest.mark.parametrize(
    "text",
    [
        csv(),
        csv(header=F1TENTH),
        csv(separator=", ", header=F1TENTH),
        csv(separator=";", header="# x_m;y_m;w_tr_right_m;w_tr_left_m"),
        csv(separator="; ", header="# 26815e17\n# x_m; y_m; w_tr_right_m; w_tr_left_m"),
        csv(separator=" "),
        csv(separator="\t", header="x_m\ty_m\tw_tr_right_m\tw_tr_left_m"),
        csv(header="x,y,width_right,width_left"),
        csv(RING[:, [0, 1, 3, 2]], header="# x_m,y_m,w_tr_left_m,w_tr_right_m"),
        csv(np.vstack([RING, RING[:1]]), header=F1TENTH),
        csv(np.repeat(RING, [2, *[1] * 119], axis=0)),
        csv().replace("\n", "\r\n") + "\r\n",
        "\n".join(line + "," for line in csv().splitlines()),
    ],
    ids=[
        "bare",
        "f1tenth",
        "blanks",
        "tum",
        "hash",
        "spaces",
        "tabs",
        "names",
        "order",
        "closed",
        "twice",
        "dos",
        "end",
    ],
)
def test_every_spelling_of_the_same_line_is_the_same_track(text: str) -> None:
    is_the_ring(text)


def test_the_line_is_driven_as_it_is_written(cli) -> None:
    turned = np.vstack([RING[:1], RING[:0:-1]])
    track = parse_centerline(csv(turned), "ring.csv")
    assert track.start_pose()[2] == pytest.approx(-0.5 * np.pi, abs=0.05)
    assert shapely.Polygon(track.walls[track.sides.index("left")]).area > np.pi * 6.7**2
    Path("ring.csv").write_text(csv())
    ran = cli("race", "ring.csv", "--laps", 1, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["outcome"] == "finished"


def test_a_circuit_of_full_size_is_scaled_and_says_so() -> None:
    track = parse_centerline(csv(10.0 * RING), "monza.csv")
    assert track.length == pytest.approx(2.0 * np.pi * 6.2, rel=0.01)
    assert track.notes == ["20.0 m wide, a full-size circuit: scaled 1:10"]


RACELINE = "\n".join(f"{0.2 * i}; {np.cos(a)}; {np.sin(a)}; 0; 1; 5; 0" for i, a in enumerate(ANGLE))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n" + RACELINE, "as in a raceline file"),
        (csv(RING[:, :3]), "3 columns; expected a centerline CSV"),
        (csv(RING[:, :2], header="# x_m,y_m"), "2 columns"),
        (csv(RING[:5]), "5 points"),
        (csv(RING[:60]), "not closed: its ends are 12.0"),
        (csv() + "1,2\n", "line 121 has 2 columns"),
        (csv() + "a,b,c,d\n", "line 121 is not numbers"),
        (csv() + "nan,0,1,1\n", "line 121 is not numbers"),
        (csv(RING * [1, 1, 0, 1]), "width outside of 0.15"),
        (csv(RING * [200, 200, 1, 1]), "longer than 5 km"),
        (csv(RING * [1, 1, 4, 1]), "width|overlaps|bends|islands"),
        (csv(np.repeat(RING[:4], 30, axis=0)), "4 different points"),
        ("only words\n", "0 points"),
        ("0,0,1,1\n" * 30_000, "more than 20000 points"),
    ],
)
def test_a_wrong_file_says_in_one_line_what_would_be_right(cli, text: str, says: str) -> None:
    Path("line.csv").write_text(text)
    with pytest.raises(InputError, match=says):
        load_centerline("line.csv")
    ran = cli("tracks", "line.csv")
    assert (ran.code, ran.err.count("\n")) == (2, 1)


def test_bytes_that_are_no_text_are_refused(cli) -> None:
    Path("line.csv").write_bytes(b"\xff\xfe\x00\x01" * 100)
    ran = cli("race", "line.csv")
    assert ran.code == 2
    assert "line.csv: not text; expected a centerline CSV" in ran.err


@pytest.mark.skipif(not MAPS.is_dir(), reason="the real maps (../shared/data) are not here")
@pytest.mark.parametrize("name", ["aut", "hangar12", "hangar16", "icra2022", "mco"])
def test_the_line_of_a_real_map_lies_between_the_walls_of_that_map(name: str) -> None:
    ours, theirs = (
        load_centerline(MAPS / name / "centerline.csv"),
        firstlap.load_track(str(MAPS / name / f"{name}.yaml")),
    )
    walls = shapely.MultiLineString(list(theirs.walls))
    away = [walls.distance(shapely.Point(x, y)) for wall in ours.walls for x, y in wall[::5]]
    assert np.median(away) < 0.15
    assert ours.length == pytest.approx(theirs.length, rel=0.1)
