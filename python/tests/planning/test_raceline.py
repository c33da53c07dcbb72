"""The racing line: closed forms, laws, and clearance of the car."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstlap
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.line import RaceLine, make_line
from firstlap.planning.raceline.line_file import load_line, read_line, write_line
from firstlap.planning.raceline.params import LINE_FIELDS, Grip, Limits, LineParams, limits_of
from firstlap.planning.raceline.path import path_through, resampled, response
from firstlap.planning.raceline.velocity import profile
from firstlap.tracks.library import list_tracks
from firstlap.tracks.track import Track

pytest.importorskip("piqp")

CAR = load_car("default")
QUICK = LineParams(spacing=0.3, time_rounds=12, curvature_rounds=8)
LIMITS = Limits(Grip(6.0, 5.0, 4.5), accel=4.0, brake=4.2, speed=9.0, curvature=1.2)


def ring(radius: float, count: int = 400) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def annulus(inner: float, outer: float) -> Track:
    closed = [np.vstack([ring(radius), ring(radius)[:1]]) for radius in (inner, outer)]
    middle, half = ring(0.5 * (inner + outer)), np.full(400, 0.5 * (outer - inner))
    return Track("annulus", closed, ["left", "right"], [True] * 2, [True] * 2, middle, half, half)


def mirrored(track: Track) -> Track:
    flip = np.array([1.0, -1.0])
    swap = {"left": "right", "right": "left"}
    return replace(
        track,
        walls=[wall * flip for wall in track.walls],
        sides=[swap.get(side, side) for side in track.sides],
        centerline=track.centerline * flip,
        width_left=track.width_right,
        width_right=track.width_left,
    )


def ellipse(line: RaceLine, limits: Limits) -> np.ndarray:
    """Utilization of the friction ellipse, by the acceleration before and after each point."""
    lateral = line.speed**2 * line.path.curvature / limits.grip.lateral
    used = []
    for accel in (line.acceleration, np.roll(line.acceleration, 1)):
        along = accel / np.where(accel > 0.0, limits.grip.drive, limits.grip.brake)
        used.append(np.hypot(along, lateral))
    return np.maximum(*used)


def test_an_annulus_gives_the_circle_at_the_inner_wall():
    inner, outer = 3.0, 4.6
    line = make_line(annulus(inner, outer), CAR, QUICK)
    limits = limits_of(CAR, QUICK)
    # At the rear axle, the side of the car keeps the margin.
    radius = inner + 0.155 + QUICK.margin
    assert line.path.curvature == pytest.approx(np.full(len(line.speed), 1.0 / radius), rel=0.02)
    assert line.length == pytest.approx(2.0 * math.pi * radius, rel=0.003)
    assert line.lap_time == pytest.approx(2.0 * math.pi * math.sqrt(radius / limits.grip.lateral), rel=0.005)


def test_the_profile_of_a_circle_is_exact():
    path = path_through(ring(2.0, 2000))
    found = profile(path.curvature, path.step, LIMITS)
    assert found.speed == pytest.approx(np.full(2000, math.sqrt(6.0 * 2.0)), rel=1e-5)
    assert found.time == pytest.approx(2.0 * math.pi * 2.0 / math.sqrt(12.0), rel=1e-5)


def test_the_profile_between_two_hairpins_accelerates_and_brakes_with_the_motor():
    step = np.full(600, 0.1)
    bend = np.zeros(600)
    bend[:10] = bend[300:310] = 1.0
    found = profile(bend, step, LIMITS)
    assert found.speed[:10] == pytest.approx(math.sqrt(6.0))
    assert found.acceleration.max() == pytest.approx(4.0)
    assert found.acceleration.min() == pytest.approx(-4.2)
    assert found.speed.max() <= LIMITS.speed
    assert found.speed[:300] == pytest.approx(found.speed[300:], abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_any_profile_keeps_inside_the_ellipse(seed):
    random = np.random.default_rng(seed)
    bend = np.convolve(random.normal(0.0, 2.0, 300), np.ones(9) / 9.0, mode="same")
    step = random.uniform(0.05, 0.2, 300)
    found = profile(bend, step, LIMITS)
    lateral = found.speed**2 * bend / LIMITS.grip.lateral
    for accel in (found.acceleration, np.roll(found.acceleration, 1)):
        along = accel / np.where(accel > 0.0, LIMITS.grip.drive, LIMITS.grip.brake)
        assert np.hypot(along, lateral).max() < 1.0 + 1e-9
    assert found.acceleration.max() < LIMITS.accel + 1e-9
    assert found.acceleration.min() > -LIMITS.brake - 1e-9
    faster = profile(bend, step, replace(LIMITS, speed=2.0 * LIMITS.speed))
    assert (faster.speed > found.speed - 1e-9).all()


def test_the_response_is_the_derivative_of_the_shape():
    random = np.random.default_rng(3)
    points = ring(3.0, 60) * (1.0 + 0.05 * random.normal(size=(60, 1)))
    path, shift = path_through(points), 1e-6 * random.normal(size=60)
    moved, reply = path_through(points + shift[:, None] * path.normal), response(path)
    assert moved.curvature - path.curvature == pytest.approx(reply.curvature @ shift, abs=1e-9)
    assert moved.step - path.step == pytest.approx(reply.step @ shift, abs=1e-9)
    assert moved.heading - path.heading == pytest.approx(reply.heading @ shift, abs=1e-9)


@pytest.mark.parametrize("name", list_tracks())
def test_the_car_is_clear_of_the_walls_all_along_the_line(name):
    track = firstlap.load_track(name)
    params = replace(QUICK, time_rounds=2, curvature_rounds=4)
    line = make_line(track, CAR, params)
    assert Corridor(track, CAR).clearance(resampled(line.path.points, 0.02).poses).min() > params.margin - 0.015
    assert ellipse(line, limits_of(CAR, params)).max() < 1.0 + 1e-6
    assert np.abs(line.path.curvature).max() < 1.05 * limits_of(CAR, params).curvature


def test_least_time_beats_least_curvature(arena):
    fast = make_line(arena, CAR, QUICK)
    assert fast.lap_time < 0.95 * make_line(arena, CAR, replace(QUICK, time_rounds=0)).lap_time


def test_a_mirrored_track_mirrors_the_line(arena):
    line, other = make_line(arena, CAR, QUICK), make_line(mirrored(arena), CAR, QUICK)
    assert other.lap_time == pytest.approx(line.lap_time, rel=2e-3)
    nearest = np.hypot(*(line.path.points[:, None] * [1.0, -1.0] - other.path.points[None]).transpose(2, 0, 1)).min(
        axis=1
    )
    assert np.median(nearest) < 0.12


def test_more_grip_is_faster_and_more_margin_is_slower():
    track = firstlap.load_track("oval")
    usual = make_line(track, CAR, QUICK).lap_time
    assert make_line(track, CAR, replace(QUICK, mu=1.0)).lap_time < 0.95 * usual
    assert make_line(track, CAR, replace(QUICK, margin=0.3)).lap_time > 1.01 * usual


def test_a_line_survives_its_file(tmp_path: Path):
    track = firstlap.load_track("oval")
    line = make_line(track, CAR, QUICK)
    write_line(line, tmp_path / "oval.csv")
    text = (tmp_path / "oval.csv").read_text().splitlines()
    assert [row.startswith("#") for row in text[:4]] == [True, True, True, False]
    assert text[2] == "# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2"
    # psi is 0 along +y, as f1tenth_racetracks has it.
    row = [float(value) for value in text[3].split(";")]
    assert math.cos(row[3] + 0.5 * math.pi - line.path.heading[0]) == pytest.approx(1.0, abs=1e-9)
    again = load_line(tmp_path / "oval.csv", track, CAR)
    assert again.path.points == pytest.approx(line.path.points, abs=1e-6)
    assert again.speed == pytest.approx(line.speed, abs=1e-6)
    assert again.lap_time == pytest.approx(line.lap_time, abs=1e-5)
    assert again.acceleration == pytest.approx(line.acceleration, abs=1e-3)


def write_rows(path: Path, points: np.ndarray, speed: float = 3.0) -> Path:
    rows = [f"0; {x}; {y}; 0; 0; {speed}; 0" for x, y in points]
    path.write_text("# a\n# b\n# c\n" + "\n".join(rows) + "\n")
    return path


def test_a_line_through_a_wall_is_refused_with_its_place(arena, tmp_path: Path):
    path = write_rows(tmp_path / "wall.csv", arena.centerline + np.array([0.0, 0.9]))
    with pytest.raises(InputError, match=r"into a wall at s = \d+\.\d m"):
        load_line(path, arena, CAR)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (ring(3.0, 100)[:60], "not closed"),
        (np.where(np.arange(200).reshape(100, 2) == 20, np.nan, ring(3.0, 100)), "line 14 .*not finite"),
        (np.repeat(ring(3.0, 50), 2, axis=0), "the same"),
        (np.delete(ring(3.0, 100), range(40, 50), axis=0), "a gap of"),
        (ring(3.0, 8), "8 points"),
    ],
)
def test_files_that_are_no_line_are_refused(points, message, tmp_path: Path):
    with pytest.raises(InputError, match=message):
        read_line(write_rows(tmp_path / "bad.csv", points))


@pytest.mark.parametrize("text", ["1;2;3", "a;b;c;d;e;f;g", "", "\x00"])
def test_texts_that_are_no_line_are_refused(text, tmp_path: Path):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(InputError):
        read_line(tmp_path / "bad.csv")


def test_a_line_without_speed_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="speed 0"):
        read_line(write_rows(tmp_path / "bad.csv", ring(3.0, 100), speed=0.0))


def test_a_track_too_narrow_for_a_wide_car_is_refused(tmp_path: Path):
    (tmp_path / "wide.yaml").write_text("geometry:\n  width: 0.99\n")
    with pytest.raises(InputError, match="into a wall"):
        make_line(firstlap.load_track("narrow"), load_car(tmp_path / "wide.yaml"), replace(QUICK, time_rounds=2))


def test_a_tight_fit_is_said(tmp_path: Path):
    (tmp_path / "wide.yaml").write_text("geometry:\n  width: 0.7\n")
    line = make_line(firstlap.load_track("narrow"), load_car(tmp_path / "wide.yaml"), replace(QUICK, margin=0.2))
    assert any("only just fits" in note for note in line.notes)


def test_the_command_writes_line_and_picture(cli):
    ran = cli(
        "line", "oval", "-o", "oval.csv", "--plot", "oval.png", "--margin", "0.15", "--set", "spacing=0.3", "--json"
    )
    assert ran.code == 0, ran.err
    assert ran.json["min_clearance"] == pytest.approx(0.15, abs=0.012)
    assert ran.json["set"] == {"line.margin": 0.15, "line.spacing": 0.3}
    assert Path("oval.png").stat().st_size > 10_000
    assert read_line("oval.csv").lap_time == pytest.approx(ran.json["lap_time"], abs=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("oval", "-o", "oval.txt"), "ending in .csv"),
        (("oval", "-o", "nowhere/oval.csv"), "no such folder"),
        (("oval", "-o", "oval.csv", "--margin", "7"), "margin"),
        (("oval", "-o", "oval.csv", "--set", "margn=0.1"), "did you mean"),
        (("ovl", "-o", "oval.csv"), "did you mean oval"),
    ],
)
def test_the_command_refuses_bad_input(arguments, message, cli):
    ran = cli("line", *arguments)
    assert ran.code == 2
    assert message in ran.err
    assert not Path("oval.csv").exists()


def test_every_default_is_within_its_range():
    for field in LINE_FIELDS.fields:
        LINE_FIELDS.check(field, field.default, "default")
