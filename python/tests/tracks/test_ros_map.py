"""ROS maps: real ones if available, drawn ones of all kinds, and invalid ones."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

from firstlap.common.errors import InputError
from firstlap.tracks.library import load_track
from firstlap.tracks.map_region import COMFORTABLE_CELLS
from firstlap.tracks.medial import distances
from firstlap.tracks.ros_map import load_ros_map, parse_ros_map_yaml
from firstlap.tracks.track import Track

MAPS = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "maps"
needs_maps = pytest.mark.skipif(not MAPS.is_dir(), reason="the real maps (../shared/data) are not here")
HEADER = """image: map.png
resolution: 0.05
origin: [-1.0, -2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
OUTER, INNER = (20, 20, 320, 220), (60, 60, 280, 180)
"""A drawn oval of 2 m width: boxes of its outer and inner wall in pixels of 0.05 m."""


def write(folder: Path, image: Image.Image, header: str = HEADER) -> Path:
    image.save(folder / "map.png")
    path = folder / "map.yaml"
    path.write_text(header)
    return path


def drawn(paper: int = 0, track: int = 254, infield: int = 0, wall: int | None = None, pen: int = 1) -> Image.Image:
    """An oval track: paper outside, infield inside, and a drawn line as the wall when `wall` is given."""
    image = Image.new("L", (340, 240), paper)
    pencil = ImageDraw.Draw(image)
    pencil.rounded_rectangle(OUTER, 60, fill=track, outline=wall, width=pen)
    pencil.rounded_rectangle(INNER, 40, fill=infield, outline=wall, width=pen)
    return image


def is_the_oval(track: Track, tolerance: float = 0.12) -> None:
    low, high = track.centerline.min(axis=0), track.centerline.max(axis=0)
    np.testing.assert_allclose(high - low, [13.0, 8.0], atol=2 * tolerance)
    assert track.length == pytest.approx(2 * (13 + 8) - (8 - 2 * np.pi) * 2.5, abs=0.6)
    assert track.width_summary()[1] == pytest.approx(2.0, abs=2 * tolerance)


@needs_maps
@pytest.mark.parametrize(
    ("name", "length", "median"),
    [
        ("germany2022", 33.2, 1.53),
        ("lausitzring1", 32.7, 1.50),
        ("lausitzring2", 31.7, 2.18),
        ("icra2022", 63.7, 1.84),
        ("hangar12", 47.0, 2.80),
        ("hangar16", 59.0, 2.06),
        ("aut", 94.1, 1.84),
        ("mco", 177.2, 1.84),
        ("gym_example", 162.6, 2.98),
    ],
)
def test_real_maps_give_the_loop_their_authors_raced(name: str, length: float, median: float) -> None:
    track = load_ros_map(MAPS / name / f"{name}.yaml")
    assert track.length == pytest.approx(length, rel=0.03)
    assert track.width_summary()[1] == pytest.approx(median, abs=0.15)
    assert all(np.allclose(wall[0], wall[-1]) for wall in track.walls)
    theirs = MAPS / name / "centerline.csv"
    if theirs.is_file():
        points = np.loadtxt(theirs, delimiter=",")[:, :2]
        assert np.median(distances(points, [np.vstack([track.centerline, track.centerline[:1]])])) < 0.25


@needs_maps
def test_a_starting_position_gives_start_and_direction() -> None:
    x, y, yaw = load_ros_map(MAPS / "hangar12" / "hangar12.yaml").start_pose()
    assert np.hypot(x + 5.95, y + 4.03) < 1.5 and np.cos(yaw - 1.675) > 0.8


@pytest.mark.parametrize(
    "image",
    [
        drawn(),
        drawn(paper=205, infield=205),
        drawn(paper=205, infield=205, wall=0, pen=2),
        drawn(paper=255, infield=255, wall=0, pen=1),
        drawn(paper=255, infield=255, wall=100, pen=3),
        drawn(paper=0, infield=255, wall=0, pen=2),
        drawn(paper=255, infield=0, wall=0, pen=3),
        drawn(paper=255, infield=255, wall=0, pen=2).convert("RGBA"),
        drawn().convert("RGB"),
        drawn().convert("P"),
        drawn().convert("1"),
        drawn().convert("I;16").point(lambda level: level * 257),
    ],
    ids=[
        "black",
        "gray",
        "slam",
        "line",
        "gray-line",
        "infield",
        "paper",
        "rgba",
        "rgb",
        "palette",
        "bits",
        "deep",
    ],
)
def test_every_way_of_drawing_the_same_track_is_read(tmp_path: Path, image: Image.Image) -> None:
    is_the_oval(load_ros_map(write(tmp_path, image)))


@pytest.mark.parametrize("extent", [(0.1, 0.5), (0.025, 2.0), (0.0125, 4.0)])
def test_coarse_and_fine_maps_give_the_same_track(tmp_path: Path, extent: tuple[float, float]) -> None:
    resolution, scale = extent
    image = drawn().resize((int(340 * scale), int(240 * scale)), Image.Resampling.BILINEAR)
    is_the_oval(load_ros_map(write(tmp_path, image, HEADER.replace("0.05", str(resolution)))), tolerance=0.15)


def test_negate_and_raw_mode(tmp_path: Path) -> None:
    inverse = drawn().point(lambda level: 255 - level)
    is_the_oval(load_ros_map(write(tmp_path, inverse, HEADER.replace("negate: 0", "negate: 1"))))
    is_the_oval(load_ros_map(write(tmp_path, inverse.point(lambda v: 0 if v < 128 else 100), HEADER + "mode: raw")))


def test_origin_and_its_yaw_place_the_track(tmp_path: Path) -> None:
    plain = load_ros_map(write(tmp_path, drawn()))
    np.testing.assert_allclose(plain.centerline.min(axis=0), [-1.0 + 2.0, -2.0 + 0.95 + 1.0], atol=0.12)
    turned = load_ros_map(write(tmp_path, drawn(), HEADER.replace("-2.0, 0.0]", "-2.0, 1.5707963]")))
    np.testing.assert_allclose(turned.centerline.max(axis=0), [-1.0 - 1.95, -2.0 + 15.0], atol=0.12)


def test_noise_gaps_and_specks_do_not_change_the_loop(tmp_path: Path) -> None:
    image = drawn(paper=205, infield=205, wall=0, pen=1)
    pixels = np.asarray(image).copy()
    generator = np.random.default_rng(1)
    pixels[(pixels == 0) & (generator.random(pixels.shape) < 0.3)] = 254
    pixels[(pixels == 205) & (generator.random(pixels.shape) < 0.1)] = 254
    for row, column in generator.integers(0, 240, (60, 2)):
        pixels[row, column] = 0
    is_the_oval(load_ros_map(write(tmp_path, Image.fromarray(pixels))), tolerance=0.2)


def test_a_small_obstacle_stays_on_the_track(tmp_path: Path) -> None:
    image = drawn()
    ImageDraw.Draw(image).rectangle((150, 198, 156, 204), fill=0)
    track = load_ros_map(write(tmp_path, image))
    assert track.sides.count("obstacle") == 1
    is_the_oval(track)


def with_piece(gray: int, box: tuple[int, int, int, int]) -> Image.Image:
    image = drawn()
    ImageDraw.Draw(image).ellipse(box, fill=gray)
    return image


ON_THE_LANE, BESIDE_THE_WALL = (140, 193, 165, 199), (140, 184, 165, 190)
"""Pieces of 1.25 x 0.3 m: in the middle of the oval's upper lane, and one gap of less than the car's width from its
inner wall."""


@pytest.mark.parametrize("gray", [100, 205])
def test_smear_on_the_lane_is_no_obstacle(tmp_path: Path, gray: int) -> None:
    track = load_ros_map(write(tmp_path, with_piece(gray, ON_THE_LANE)))
    clean = load_ros_map(write(tmp_path, drawn()))
    assert "obstacle" not in track.sides and track.sides.count("left") == 1
    np.testing.assert_array_equal(track.centerline, clean.centerline)
    assert any(note.startswith("removed 1 pieces of smear") for note in track.notes)


@pytest.mark.parametrize("pixels", [1, 20])
def test_what_has_an_occupied_pixel_is_solid(tmp_path: Path, pixels: int) -> None:
    image = with_piece(205, ON_THE_LANE)
    ImageDraw.Draw(image).line((145, 196, 144 + pixels, 196), fill=0)
    track = load_ros_map(write(tmp_path, image))
    assert track.sides.count("obstacle") + track.sides.count("left") == 2
    assert not any("smear" in note for note in track.notes)


def test_what_is_occupied_is_said_by_the_maps_own_threshold(tmp_path: Path) -> None:
    image = with_piece(100, ON_THE_LANE)  # its occupancy is 0.61
    path = write(tmp_path, image, HEADER.replace("0.65", "0.6"))
    assert load_ros_map(path).sides.count("obstacle") + load_ros_map(path).sides.count("left") == 2


def test_a_piece_of_gray_without_a_passage_to_the_wall_belongs_to_the_wall(tmp_path: Path) -> None:
    track = load_ros_map(write(tmp_path, with_piece(205, BESIDE_THE_WALL)))
    assert track.width_summary()[0] < 1.7 and not any("smear" in note for note in track.notes)


def test_an_infield_of_thin_gray_is_kept_if_the_loop_goes_around_it(tmp_path: Path) -> None:
    image = Image.new("L", (340, 240), 0)
    pencil = ImageDraw.Draw(image)
    pencil.rounded_rectangle(OUTER, 60, fill=254)
    pencil.line((100, 120, 240, 120), fill=205, width=4)
    track = load_ros_map(write(tmp_path, image))
    assert track.sides.count("left") == 1 and not any("smear" in note for note in track.notes)


def two_lanes() -> Image.Image:
    """An oval with an island in its upper lane, which is drawn wide enough for a lane on both sides of it."""
    image = Image.new("L", (340, 300), 0)
    pencil = ImageDraw.Draw(image)
    pencil.rounded_rectangle((20, 20, 320, 280), 60, fill=254)
    pencil.rounded_rectangle((60, 60, 280, 180), 40, fill=0)
    pencil.rectangle((120, 220, 220, 240), fill=0)
    return image


def test_the_yaml_key_loop_selects_among_the_loops_that_the_reader_lists(tmp_path: Path) -> None:
    path = write(tmp_path, two_lanes())
    chosen = load_ros_map(path)
    (selected,) = [note for note in chosen.notes if note.startswith("selected")]
    (others,) = [note for note in chosen.notes if "`loop: N`" in note]
    assert "of 3 possible loops: " in selected and others.count("narrowest") == 2
    loops = [load_ros_map(write(tmp_path, two_lanes(), HEADER + f"loop: {n}")) for n in (1, 2, 3)]
    assert loops[0].length > loops[1].length + 0.5 > loops[2].length + 1.0
    assert sum(np.array_equal(loop.centerline, chosen.centerline) for loop in loops) == 1
    assert all("as the map's YAML file says" in str(loop.notes) for loop in loops)
    with pytest.raises(InputError, match=r"loop is 4; this map has loop 1 .*, loop 2 .*, loop 3 "):
        load_ros_map(write(tmp_path, two_lanes(), HEADER + "loop: 4"))


def test_a_starting_position_still_sets_the_start_on_a_chosen_loop(tmp_path: Path) -> None:
    start = "starting_positions: [[7.0, -0.3, 3.1]]\n"
    track = load_ros_map(write(tmp_path, two_lanes(), HEADER + start + "loop: 1"))
    assert not shapely.LinearRing(track.centerline).is_ccw
    assert "as the map's YAML file says" in str(track.notes)


def test_an_island_wall_with_wide_gaps_is_gone_round_as_a_whole(tmp_path: Path) -> None:
    image = drawn()
    ImageDraw.Draw(image).rectangle((165, 55, 180, 190), fill=254)
    track = load_ros_map(write(tmp_path, image))
    is_the_oval(track)
    assert track.sides.count("left") == 2 and any("possible loops" in note for note in track.notes)


def test_a_wall_one_pixel_thick_between_two_lanes_stays_opaque(tmp_path: Path) -> None:
    image = Image.new("L", (300, 100), 0)
    pencil = ImageDraw.Draw(image)
    pencil.rectangle((10, 10, 289, 89), fill=254)
    pencil.line((50, 50, 249, 53), fill=0)
    track = load_ros_map(write(tmp_path, image))
    across = shapely.LineString([(-1 + 150 * 0.05, -2 + 1.0), (-1 + 150 * 0.05, -2 + 4.0)])
    assert shapely.MultiLineString(track.walls).intersection(across).length == 0.0
    assert across.intersects(shapely.MultiLineString(track.walls))
    assert track.width_summary()[1] == pytest.approx(1.95, abs=0.1)


def test_the_direction_is_counter_clockwise_unless_the_start_says_otherwise(tmp_path: Path) -> None:
    area = [
        shapely.LinearRing(load_ros_map(write(tmp_path, drawn(), HEADER + start)).centerline).is_ccw
        for start in (
            "",
            "starting_positions: [[99, 99, 0], [7.0, -0.3, 3.1]]",
            "starting_positions: [[7.0, -0.3, 0]]",
        )
    ]
    assert area == [True, False, True]


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("", "empty"),
        ("just text", "key: value"),
        ("image: [", "not YAML"),
        (HEADER.replace("image: map.png\n", ""), "missing 'image'"),
        (HEADER.replace("map.png", "other.png"), "no such image"),
        (HEADER.replace("map.png", "map.yaml"), "not a readable image"),
        (HEADER.replace("map.png", "."), "is a folder"),
        (HEADER.replace("map.png", "[1]"), "expected a file name"),
        (HEADER.replace("0.05", "0"), "resolution"),
        (HEADER.replace("0.05", "-1"), "resolution"),
        (HEADER.replace("0.05", ".nan"), "resolution"),
        (HEADER.replace("0.05", "1e300"), "resolution"),
        (HEADER.replace("0.05", "50"), "resolution"),
        (HEADER.replace("0.05", "1" * 5000), "5000 characters; at most 3000"),
        (HEADER.replace("[-1.0, -2.0, 0.0]", "[1, 2]"), "three numbers"),
        (HEADER.replace("[-1.0, -2.0, 0.0]", "[1, 2, .inf]"), "finite"),
        (HEADER.replace("[-1.0, -2.0, 0.0]", "null"), "three numbers"),
        (HEADER.replace("0.196", "-0.1"), "expected 0 to 1"),
        (HEADER.replace("negate: 0", "negate: maybe"), "negate"),
        (HEADER + "mode: fancy", "trinary, scale or raw"),
        (HEADER + "loop: 0", "loop is 0; expected an integer from 1"),
        (HEADER + "loop: 1.5", "loop is 1.5; expected an integer from 1"),
        (HEADER + "loop: two", "loop is 'two'; expected a finite number"),
        (HEADER + "loop: 2", r"loop is 2; this map has loop 1 \(37\..* m, narrowest 2\.00 m\)"),
        (HEADER + "starting_positions: [[1, 2]]", "three numbers"),
        ("a: &a [x, x]\nb: &b [*a, *a]\n", "aliases"),
        (HEADER.replace("0.05", "0.002"), "closed loop"),
        (HEADER.replace("0.05", "0.01"), "too narrow|narrowest|closed loop"),
    ],
)
def test_a_wrong_header_says_in_one_line_what_would_be_right(tmp_path: Path, header: str, says: str) -> None:
    path = write(tmp_path, drawn(), header)
    with pytest.raises(InputError, match=says) as caught:
        load_ros_map(path)
    assert "\n" not in str(caught.value) and str(tmp_path) in str(caught.value)


def horseshoe() -> Image.Image:
    image = drawn()
    ImageDraw.Draw(image).rectangle((150, 0, 190, 80), fill=0)
    return image


@pytest.mark.parametrize(
    ("image", "says"),
    [
        (Image.new("L", (50, 50), 254), "every pixel is free"),
        (Image.new("L", (50, 50), 0), "every pixel is occupied"),
        (Image.new("L", (2, 2), 0), "too small"),
        (horseshoe(), "closed loop"),
        (Image.new("1", (9000, 9000)), "million"),
        (
            Image.fromarray(np.random.default_rng(0).integers(0, 256, (400, 400), dtype=np.uint8)),
            "closed loop",
        ),
    ],
    ids=["white", "black", "tiny", "horseshoe", "gigantic", "noise"],
)
def test_a_picture_without_a_track_is_refused(tmp_path: Path, image: Image.Image, says: str) -> None:
    with pytest.raises(InputError, match=says):
        load_ros_map(write(tmp_path, image))


@pytest.mark.parametrize("share", [0.01, 0.03, 0.1, 0.5, 0.97])
def test_a_large_picture_of_noise_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    monkeypatch.setattr("firstlap.tracks.ros_map.without_specks", None)
    noise = np.random.default_rng(0).random((2000, 2000)) < share
    path = write(tmp_path, Image.fromarray(np.where(noise, 0, 254).astype(np.uint8)))
    with pytest.raises(InputError, match=r"separate pieces .* not noise"):
        load_ros_map(path)


def test_an_ugly_map_with_a_thousand_specks_is_still_read(tmp_path: Path) -> None:
    pixels = np.asarray(drawn(paper=205, infield=205, wall=0, pen=2)).copy()
    specks = np.random.default_rng(2).random(pixels.shape) < 0.03
    pixels[specks & (pixels == 205)] = 0
    pixels[np.roll(specks, 50, axis=1) & (pixels == 205)] = 254
    is_the_oval(load_ros_map(write(tmp_path, Image.fromarray(pixels))))


def test_a_loop_is_the_same_looked_for_finely_or_coarsely(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, drawn())
    fine = load_ros_map(path)
    monkeypatch.setattr("firstlap.tracks.map_region.COMFORTABLE_CELLS", 5_000)
    coarse = load_ros_map(path)
    np.testing.assert_allclose(coarse.centerline, fine.centerline)


def test_damaged_images_never_give_a_traceback(tmp_path: Path) -> None:
    path = write(tmp_path, drawn(paper=205, infield=205, wall=0))
    whole = (tmp_path / "map.png").read_bytes()
    generator = np.random.default_rng(3)
    for _ in range(60):
        damaged = bytearray(whole[: int(generator.integers(0, len(whole)))] if generator.random() < 0.3 else whole)
        for _ in range(int(generator.integers(0, 6))):
            if damaged:
                damaged[int(generator.integers(len(damaged)))] = int(generator.integers(256))
        (tmp_path / "map.png").write_bytes(bytes(damaged))
        try:
            load_ros_map(path)
        except InputError as error:
            assert "\n" not in str(error)


def test_damaged_headers_never_give_a_traceback() -> None:
    generator = np.random.default_rng(4)
    text = HEADER + "mode: trinary\nstarting_positions:\n - [1, 2, 3]\n"
    letters = "[]{}:-&*!|>'\"%@`,#?\n\t 0123456789.eEnaif\0\u2028"
    for _ in range(2000):
        damaged = list(text)
        for _ in range(int(generator.integers(1, 8))):
            damaged[int(generator.integers(len(damaged)))] = letters[int(generator.integers(len(letters)))]
        try:
            parse_ros_map_yaml("".join(damaged), "fuzz")
        except InputError as error:
            assert "\n" not in str(error)


def test_a_missing_or_binary_map_file_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "image.yaml").write_bytes(b"\x89PNG\r\n\xff\xfe\0\0")
    for name in ("image.yaml", "missing.yaml", "."):
        with pytest.raises(InputError):
            load_ros_map(tmp_path / name)


def test_load_track_tells_a_map_from_a_track_file_by_its_content(tmp_path: Path) -> None:
    is_the_oval(load_track(str(write(tmp_path, drawn()))))


def test_a_large_map_is_read_in_bounded_time(tmp_path: Path) -> None:
    image = drawn().resize((3400, 2400), Image.Resampling.NEAREST)
    assert image.width * image.height > 5 * COMFORTABLE_CELLS
    path = write(tmp_path, image, HEADER.replace("0.05", "0.02"))
    begin = time.perf_counter()
    with pytest.raises(InputError, match=r"closed loop|too large"):
        load_ros_map(path)
    assert time.perf_counter() - begin < 60.0


MORE = MAPS.parent / "more" / "maps"


@pytest.mark.skipif(not MORE.is_dir(), reason="the maps of other teams (../shared/data) are not here")
@pytest.mark.parametrize("name", ["hall_0822", "hangeong", "lobby_0723", "lobby_0728", "lobby_0730", "lobby_0731"])
def test_a_map_with_crossed_thresholds_is_the_track_that_map_server_shows(name: str) -> None:
    published = load_ros_map(MORE / f"ssu_{name}" / f"ssu_{name}.yaml")
    mended = load_ros_map(MORE / f"ssu_{name}" / f"ssu_{name}_fixed.yaml")
    assert published.length == pytest.approx(mended.length, rel=0.01)
    assert any("above occupied_thresh" in note for note in published.notes)
    assert not any("above occupied_thresh" in note for note in mended.notes)


def test_crossed_thresholds_are_asked_for_occupied_first(tmp_path: Path) -> None:
    crossed = HEADER.replace("0.65", "0.065").replace("0.196", "0.25")
    grays = drawn(paper=205, infield=225, track=254)
    is_the_oval(load_ros_map(write(tmp_path, grays, crossed)))  # 225: below free_thresh, and above occupied_thresh


def carved(image: Image.Image, alpha: int) -> Image.Image:
    """An image with this opacity where it is black."""
    shown = image.convert("RGBA")
    shown.putalpha(image.point(lambda level: 255 if level else alpha))
    return shown


@pytest.mark.parametrize("alpha", [0, 100, 255])
def test_what_is_transparent_around_a_white_track_is_not_free(tmp_path: Path, alpha: int) -> None:
    is_the_oval(load_ros_map(write(tmp_path, carved(drawn(), alpha))))
    is_the_oval(load_ros_map(write(tmp_path, carved(drawn(), alpha), HEADER + "mode: scale\n")))


def test_a_drawing_on_nothing_is_refused_for_its_transparency(tmp_path: Path) -> None:
    lines = drawn(paper=255, infield=255, track=255, wall=0, pen=3)
    image = lines.convert("RGBA")
    image.putalpha(lines.point(lambda level: 0 if level else 255))
    with pytest.raises(InputError, match="% of the image is transparent, which map_server treats as occupied"):
        load_ros_map(write(tmp_path, image))


def test_grays_of_probability_are_named_where_they_leave_no_track(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    gray = np.asarray(drawn(paper=128, infield=128, track=254)).copy()
    inside = gray == 254
    gray[inside] = rng.integers(150, 200, inside.sum())  # as Cartographer draws cells with few free observations
    with pytest.raises(InputError, match=r"Cartographer.*free_thresh 0.45 they are free"):
        load_ros_map(write(tmp_path, Image.fromarray(gray)))
    is_the_oval(load_ros_map(write(tmp_path, Image.fromarray(gray), HEADER.replace("0.196", "0.45"))))
