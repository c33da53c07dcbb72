"""The command line: output streams and exit codes."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import PATIENCE

ROOT = Path(__file__).resolve().parents[3]
PNG = b"\x89PNG\r\n"
RACE_KEYS = {
    "version",
    "track",
    "track_length",
    "direction",
    "driver",
    "latency",
    "skipped_scans",
    "setup",
    "set",
    "car",
    "options",
    "seed",
    "outcome",
    "laps",
    "best",
    "contact",
    "ending",
    "compute",
}
LAP_KEYS = {"time", "distance", "mean_speed", "max_speed", "min_clearance", "rms_offset", "standing"}


def test_race_prints_one_json_object_and_nothing_else(cli):
    ran = cli("race", "oval", "--setup", "base", "--laps", 2, "--json")
    assert ran.code == 0
    assert ran.err == ""
    assert set(ran.json) == RACE_KEYS
    assert [set(lap) for lap in ran.json["laps"]] == [LAP_KEYS, LAP_KEYS]
    assert [lap["standing"] for lap in ran.json["laps"]] == [True, False]
    assert ran.json["outcome"] == "finished"
    assert ran.json["best"] == min(lap["time"] for lap in ran.json["laps"])
    assert set(ran.json["compute"]) == {"p50", "p99", "max"}


def test_race_prints_a_table_and_writes_a_picture(cli):
    ran = cli("race", "oval", "--setup", "base", "--laps", 1, "--plot", "a.png")
    assert ran.code == 0
    assert "standing start" in ran.out
    assert "a.png" in ran.out
    assert Path("a.png").read_bytes().startswith(PNG)
    assert [path.name for path in Path().iterdir()] == ["a.png"]


def test_the_same_seed_gives_the_same_json(cli):
    first, second, other = (
        cli("race", "arena", "--setup", "base", "--laps", 1, "--seed", seed, "--json").json for seed in (3, 3, 4)
    )
    for found in (first, second, other):
        del found["compute"]
    assert first == second
    assert first["laps"] != other["laps"]


def test_race_that_touches_a_wall_exits_1_and_says_where(cli):
    ran = cli(
        "race", "arena", "--setup", "race", "--set", "a_y_max=15", "--set", "v_min=8", "--set", "v_max=15", "--json"
    )
    assert ran.code == 1
    assert ran.json["outcome"] == "contact"
    assert set(ran.json["contact"]) == {"time", "x", "y", "s", "obstacle"}


def test_set_takes_short_and_long_names(cli):
    ran = cli(
        "race", "oval", "--setup", "base", "--laps", 1, "--set", "k_ang=0.5", "--set", "stanley.k_dist=1", "--json"
    )
    assert ran.json["set"] == {"stanley.k_ang": 0.5, "stanley.k_dist": 1.0}


def test_reverse_drives_the_other_way_round(cli):
    ran = cli("race", "arena", "--setup", "base", "--laps", 1, "--reverse", "--json")
    assert ran.json["direction"] == "reverse"


def test_survey_counts_races(cli):
    ran = cli("survey", "oval", "random:1-2", "--setup", "base", "--laps", 1, "--seeds", 2, "--both", "--json")
    assert [track["track"] for track in ran.json["tracks"]] == ["oval", "random:1", "random:2"]
    assert ran.json["runs"] == 12
    oval = ran.json["tracks"][0]
    assert (oval["runs"], oval["finished"], oval["success_rate"], oval["failures"]) == (4, 4, 1.0, [])
    assert oval["best"] <= oval["median"]
    assert oval["min_clearance"] > 0.0
    assert ran.code == (0 if ran.json["finished"] == 12 else 1)


def test_survey_tells_its_failures(cli):
    ran = cli("survey", "arena", "--setup", "race", "--set", "v_min=8", "--set", "a_y_max=15", "--seeds", 1, "--json")
    assert ran.code == 1
    failure = ran.json["tracks"][0]["failures"][0]
    assert failure["outcome"] == "contact"
    assert failure["seed"] == 1


def test_survey_prints_a_table(cli):
    ran = cli("survey", "oval", "--setup", "base", "--laps", 1, "--seeds", 1)
    assert ran.code == 0
    assert "1/1" in ran.out


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_interrupted_survey_prints_what_is_finished():
    script = (
        "import sys\n"
        "from firstlap.cli import main\n"
        "from firstlap.evaluation.survey import Survey\n"
        "drive = Survey.drive\n"
        "def told(self, runs, done):\n"
        "    drive(self, runs, lambda *race: (done(*race), print('raced', file=sys.stderr, flush=True)))\n"
        "Survey.drive = told\n"
        "main()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script, "survey", "oval", "--setup", "base", "--seeds", "2000", "--laps", "5"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    assert process.stderr.readline() == "raced\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    assert out.rstrip().endswith("finished")
    # Our own lines of races that ended before the interrupt was heard stand before it.
    assert re.fullmatch(r"(raced\n)*error: interrupted after \d+ of 2000 races\n", err)


def test_explain_draws_a_step_of_a_race(cli):
    ran = cli("explain", "arena", "--at", 12.5, "--setup", "base")
    assert ran.code == 0
    assert Path("explain.png").read_bytes().startswith(PNG)


def test_explain_draws_the_last_step_of_a_race_that_ended(cli):
    ran = cli("explain", "arena", "--at", 45, "--setup", "race", "--set", "v_min=8", "--set", "a_y_max=15")
    assert ran.code == 0
    assert "contact" in ran.out


def test_check_prints_the_rules_and_warns(cli):
    assert "no warnings" in cli("check", "base").out
    ran = cli("check", "race")
    assert ran.code == 0
    assert "warning" in ran.out


def test_check_rules_by_their_numbers(cli):
    rules = {rule["name"]: rule for rule in cli("check", "base", "--json").json["rules"]}
    assert rules["neutral lookahead, nearly straight"]["value"] == pytest.approx(0.6 * (1 + 0.2 / 0.33))
    assert rules["delay"]["value"] == pytest.approx(4.0 * 0.6 / 0.33 * 0.1)
    assert rules["grip at full lock"]["value"] == pytest.approx(5.4, abs=0.01)


def test_tracks_lists_ours(cli):
    names = [track["track"] for track in cli("tracks", "--json").json["tracks"]]
    assert "arena" in names
    assert len(names) >= 10
    assert "arena" in cli("tracks").out


def test_tracks_measures_those_that_are_named(cli):
    rows = cli("tracks", "oval", "random:3", "--json").json["tracks"]
    assert [row["track"] for row in rows] == ["oval", "random:3"]
    assert rows[0]["width"]["min"] <= rows[0]["width"]["median"] <= rows[0]["width"]["max"]
    assert "nowhere" in cli("tracks", "nowhere").err
    assert cli("tracks", "nowhere").code == 2


def test_tracks_drivable_says_for_each_direction_whether_a_lap_exists(cli):
    (row,) = cli("tracks", "--drivable", "narrow", "--json").json["tracks"]
    assert [way["direction"] for way in row["drivable"]] == ["forward", "opposite"]
    for way in row["drivable"]:
        assert way["drivable"] is True and way["blocked_at"] is None
        assert way["turning_radius"] < way["largest_radius"] and way["margin"] < way["largest_margin"]
    assert "forward" in cli("tracks", "--drivable", "narrow").out


def test_tracks_says_where_a_corner_is_tighter_than_the_car(cli, tmp_path):
    car = tmp_path / "truck.yaml"
    car.write_text("geometry:\n  steering_limit: 0.12\n")
    plain = cli("tracks", "narrow", "--car", car)
    assert plain.code == 0 and "opposite: no lap found for a car that turns with 2.74 m" in plain.out
    found = cli("tracks", "narrow", "--drivable", "--car", car)
    assert "not drivable; the search gets to (" in found.out and "the tightest curve there is at" in found.out
    assert re.search(r"the car turns with 2\.74 m, and a turning radius of up to [012]\.\d\d m would do", found.out)


def test_tracks_refuses_a_margin_without_effect(cli):
    ran = cli("tracks", "oval", "--margin", 0.1)
    assert ran.code == 2 and "--margin: has no effect without --drivable" in ran.err


def test_bench_returns_its_numbers(cli):
    found = cli("bench", "oval", "--setup", "base", "--json").json
    for key in ("step_us", "scan_us", "reference_us"):
        assert 0.0 < found[key]["p50"] <= found[key]["p99"]
    assert found["realtime_factor"] > 0.0


def test_version(cli):
    assert re.fullmatch(r"firstlap \d+\.\d+\.\d+\n", cli("--version").out)


BAD = {
    "no such track": ("race", "arenna"),
    "no such file": ("race", "nothing/map.yaml"),
    "no such setup": ("race", "arena", "--setup", "bse"),
    "no such car": ("race", "arena", "--setup", "base", "--car", "truck"),
    "unknown parameter": ("race", "arena", "--setup", "base", "--set", "k_angg=1"),
    "not a number": ("race", "arena", "--setup", "base", "--set", "k_ang=fast"),
    "nan": ("race", "arena", "--setup", "base", "--set", "k_ang=nan"),
    "no value": ("race", "arena", "--setup", "base", "--set", "k_ang"),
    "out of range": ("race", "arena", "--setup", "base", "--set", "k_ang=99"),
    "contradiction": ("race", "arena", "--setup", "base", "--set", "v_min=5"),
    "no laps": ("race", "arena", "--setup", "base", "--laps", 0),
    "gigantic seed": ("race", "arena", "--setup", "base", "--seed", 2**64),
    "unknown option": ("race", "arena", "--fast"),
    "unknown command": ("overtake",),
    "nothing to race": ("race",),
    "no folder for the picture": ("race", "arena", "--setup", "base", "--plot", "no/such/a.png"),
    "no plot": ("race", "arena", "--setup", "base", "--plot", "a.txt"),
    "bad survey": ("survey", "arena", "nowhere"),
    "bad range of tracks": ("survey", "random:9-1"),
    "nothing to explain": ("explain",),
    "two things to explain": ("explain", "arena", "--at", 1, "--scan", 1),
    "too far": ("explain", "arena", "--setup", "base", "--at", 1e9),
    "before the start": ("explain", "arena", "--setup", "base", "--at", -1),
    "no recording": ("explain", "a.npz", "--setup", "base", "--scan", 0),
    "nothing to replay": ("replay", "a.npz"),
    "invalid setup": ("check", "nothing.yaml"),
    "no driver in the paper's comparison": ("paper", "oval", "-o", "p", "--drivers", ""),
    "unknown driver in the paper's comparison": ("paper", "oval", "-o", "p", "--drivers", "fast"),
    "a car without a name": ("explain", "arena", "--setup", "base", "--car", ""),
}


@pytest.mark.parametrize("arguments", BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line_and_exit_2(cli, arguments):
    ran = cli(*arguments)
    assert ran.code == 2
    assert ran.out == ""
    assert re.fullmatch(r"error: .+\n", ran.err)
    assert not list(Path().iterdir())


def test_unknown_name_tells_the_nearest(cli):
    assert "stanley.k_ang" in cli("race", "arena", "--setup", "base", "--set", "k_angg=1").err
    assert "base" in cli("race", "arena", "--setup", "bse").err


def test_out_of_range_tells_name_value_and_range(cli):
    ran = cli("race", "arena", "--setup", "base", "--set", "k_ang=99")
    for word in ("stanley.k_ang", "99", "0 to 2"):
        assert word in ran.err


def test_a_picture_that_cannot_be_written_leaves_the_old_one(cli, monkeypatch):
    Path("a.png").write_text("old")

    def broken(*_arguments: object, **_options: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", broken)
    ran = cli("race", "oval", "--setup", "base", "--laps", 1, "--plot", "a.png")
    assert ran.code == 2
    assert "No space left" in ran.err
    assert [(path.name, path.read_text()) for path in Path().iterdir()] == [("a.png", "old")]


def readme_blocks(language: str) -> list[str]:
    """The code blocks of the README."""
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)


README_SESSIONS = [
    commands
    for block in readme_blocks("sh")
    if (commands := [line.split("#")[0].split()[1:] for line in block.splitlines() if line.startswith("firstlap ")])
]


@pytest.mark.parametrize("session", README_SESSIONS, ids=lambda session: session[0][0])
def test_commands_of_the_readme(cli, session):
    for arguments in session:
        assert cli(*arguments).code == 0, arguments


def test_python_of_the_readme(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for block in readme_blocks("python"):
        exec(compile(block, "README.md", "exec"), {})
    assert Path("arena.png").is_file()


def test_make_targets_of_the_documents_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    for document in ("README.md", "CONTRIBUTING.md"):
        text = (ROOT / document).read_text(encoding="utf-8")
        assert set(re.findall(r"(?:^|`)make ([a-z-]+)", text, re.MULTILINE)) <= targets


def test_generated_pages_are_current():
    subprocess.run([sys.executable, ROOT / "scripts" / "generate_docs.py", "--check"], check=True)


def test_a_key_that_stands_twice_in_a_track_is_refused(cli, tmp_path):
    track = tmp_path / "twice.yaml"
    track.write_text("name: a\nname: b\n")
    ran = cli("race", track)
    assert ran.code == 2
    assert "'name' is given twice" in ran.err


def test_brackets_without_end_are_refused_at_once(cli, tmp_path):
    setup = tmp_path / "nested.yaml"
    setup.write_text("[" * 20_000)
    ran = cli("check", setup)
    assert ran.code == 2
    assert "nested" in ran.err


def test_a_track_may_be_named_like_markup_or_mathematics(cli, tmp_path):
    lines = (ROOT / "tracks" / "oval.yaml").read_text().splitlines()
    named = ["name: '[bold]x[/foo] $a_{ $'" if line.startswith("name:") else line for line in lines]
    track = tmp_path / "odd.yaml"
    track.write_text("\n".join(named))
    picture = tmp_path / "a[red].png"
    ran = cli("race", track, "--laps", 1, "--plot", picture)
    assert ran.code == 0, ran.err
    assert "[bold]x[/foo]" in ran.out
    assert picture.exists()


def test_the_help_of_every_command_speaks_no_python(cli):
    import typer

    from firstlap.cli import app

    names = sorted(typer.main.get_command(app).commands)
    assert {"race", "survey", "tune"} <= set(names)
    for name in names:
        text = cli(name, "--help").out
        assert text.count("Usage: firstlap") == 1
        for word in ("list[", "<str>", "...}..."):
            assert word not in text, name


def test_a_survey_calls_a_map_by_its_files_name_and_one_seed_one_seed(cli, tmp_path):
    track = tmp_path / "a_folder_of_a_very_long_name" / "mine.yaml"
    track.parent.mkdir()
    track.write_text((ROOT / "tracks" / "oval.yaml").read_text())
    ran = cli("survey", track, "--laps", 1, "--seeds", 1)
    assert "1 lap, 1 seed" in ran.out
    assert "1 of 1 race finished" in ran.out
    assert "very_long_name" not in ran.out
    assert "mine" in ran.out
