"""Sources of the pit wall: a simulated race in its process, and a recording with playback and changed parameters."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_result import CommandResult

import firstlap
from firstlap.cli import view
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import Setup, load_setup
from firstlap.drivers.racer import step_core
from firstlap.pitwall import lap_setup
from firstlap.pitwall.conditions import Conditions
from firstlap.pitwall.frame import DrivenLap, Frame
from firstlap.pitwall.lap_setup import changed_from
from firstlap.pitwall.recording_source import RecordingSource, begin_of_memory
from firstlap.pitwall.sim_laps import KEPT_LINES, with_lap
from firstlap.pitwall.sim_process import run
from firstlap.pitwall.sim_race import Plan, SimRace
from firstlap.pitwall.sim_source import SimSource
from firstlap.pitwall.source import Drives, Plays, Simulates
from firstlap.recordings import Recording, load_recording
from firstlap.sim.race import race
from firstlap.sim.race_process import bare, packed

LONG = 20.0
"""[s] Timeout of waits."""


def wait(what: Callable[[], Any], seconds: float = LONG) -> Any:
    """Waits for the first true result."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(0.002)
    raise AssertionError("it did not come to be")


def shown(source: Any, what: Callable[[Frame], bool]) -> Frame:
    """Waits for the first frame that satisfies the condition."""
    return wait(lambda: (frame := source.latest()) and what(frame) and frame)


def plan(track: firstlap.Track, setup: str = "sure", **values: float) -> Plan:
    return Plan(bare(track), packed(load_car("default")), load_setup(setup), 1, values)


def sim_race(track: firstlap.Track, setup: str = "sure", **values: float) -> SimRace:
    made = SimRace(plan(track, setup))
    for name, value in values.items():
        made.set_condition(made.conditions.table.find(name, "test").key, value)
    made.set_setup(load_setup(setup))
    return made


# SimRace, in this process.


@pytest.mark.parametrize("computing", [0.0, 0.01, 0.06])
def test_the_shown_race_is_the_race_that_is_raced(arena: firstlap.Track, computing: float) -> None:
    raced = race(arena, "sure", options={"compute_latency": computing}, laps=1).path
    watched = sim_race(arena, compute_latency=computing)
    poses = []
    for _ in range(200):
        watched.tick()
        truth = watched.world.truth(0)
        poses.append([truth["x"], truth["y"]])
    np.testing.assert_allclose(np.array(poses), np.column_stack([raced["x"], raced["y"]])[:200], atol=1e-6)


def test_a_lap_is_counted_with_its_line(arena: firstlap.Track) -> None:
    raced = race(arena, "sure", laps=2)
    watched = sim_race(arena)
    while len(watched.laps) < 2:
        watched.tick()
    first, second = watched.laps
    assert (first.number, first.standing, second.number, second.standing) == (1, True, 2, False)
    assert second.time == pytest.approx(raced.laps[1].time, abs=1e-6)
    assert second.clearance == pytest.approx(raced.laps[1].min_clearance, abs=1e-3)
    assert len(second.line) == len(second.speed) == pytest.approx(second.time / watched.period, abs=2)
    assert np.hypot(*np.diff(second.line, axis=0).T).sum() == pytest.approx(raced.laps[1].distance, rel=0.01)
    assert "lap 2 in" in watched.message


def test_a_lap_says_which_setup_drove_it(arena: firstlap.Track) -> None:
    watched, sure = sim_race(arena), load_setup("sure")
    faster = changed_from(sure.with_values({"v_max": 3.0, "k_ang": sure.get("k_ang")}), sure)
    for wanted, setup in ((1, faster), (2, faster), (3, load_setup("race"))):
        while len(watched.laps) < wanted:
            watched.tick()
        watched.set_setup(setup)
        watched.tick()
    while len(watched.laps) < 4:
        watched.tick()
    assert [lap_setup.short(lap) for lap in watched.laps] == ["sure", "… sure +1", "sure +1", "… race"]
    assert lap_setup.long(watched.laps[2]) == "setup sure; v_max 3"
    assert lap_setup.long(watched.laps[3]) == "setup race; setup changed during the lap"


def test_the_pace_that_was_asked_for_counts_as_loaded(arena: firstlap.Track) -> None:
    source = SimSource(arena, load_setup("sure"), load_car("default"), pace=4.0)
    assert source.condition("pace") == source.conditions.find("pace", "test").default == 4.0


def test_a_change_that_is_taken_back_is_none() -> None:
    loaded = load_setup("sure").with_assignments(["k_ang=0.3"])
    changed = changed_from(loaded.with_values({"v_max": 3.0, "k_dist": 0.5}), loaded)
    back = changed_from(changed.with_values({"v_max": loaded.get("v_max")}), loaded)
    assert {name for _, name in changed.changed} == {"k_ang", "v_max", "k_dist"}
    assert {name for _, name in back.changed} == {"k_ang", "k_dist"}
    assert back.get("v_max") == loaded.get("v_max")


def test_old_lines_are_forgotten_but_for_the_best() -> None:
    laps: tuple[DrivenLap, ...] = ()
    for number in range(1, KEPT_LINES + 21):
        lap = DrivenLap(number, 10.0 - (number == 5), np.zeros((3, 2)), np.zeros(3))
        laps = with_lap(laps, lap)
    assert len(laps) == KEPT_LINES + 20
    assert [lap.number for lap in laps if len(lap.line)] == [5, *range(21, KEPT_LINES + 21)]


def test_friction_changes_under_the_driving_car(arena: firstlap.Track) -> None:
    watched = sim_race(arena, "race")
    hardest = {}
    for friction in (1.0, 0.4):
        watched.set_condition("world.mu_scale", friction)
        hardest[friction], before = 0.0, watched.world.truth(0)
        watched.tick()
        after = watched.world.truth(0)
        assert np.hypot(after["x"] - before["x"], after["y"] - before["y"]) < 0.2
        for _ in range(200):
            watched.tick()
            hardest[friction] = max(hardest[friction], abs(watched.world.truth(0)["lateral_acceleration"]))
    assert hardest[0.4] < 0.4 * 0.75 * 9.81 * 1.05 < hardest[1.0]
    assert watched.epoch == 0


def test_a_contact_is_said_until_the_car_is_placed(arena: firstlap.Track) -> None:
    watched = sim_race(arena, "race", mu_scale=0.2)
    for _ in range(2000):
        watched.tick()
        if not watched.frame().may_drive:
            break
    frame = watched.frame()
    assert "contact at" in frame.message
    assert "m: place the car or restart" in frame.message
    watched.go()
    watched.tick()
    assert not watched.frame().may_drive
    watched.set_condition("world.mu_scale", 1.0)
    watched.place(arena.start_pose(5.0))
    for _ in range(40):
        watched.tick()
    assert watched.frame().may_drive
    assert watched.frame().speed > 0.5
    assert not watched.message


def test_a_stop_counts_from_its_moment_and_not_from_the_next_scan(arena: firstlap.Track) -> None:
    speeds = {}
    for stopped in (False, True):
        watched = sim_race(arena)
        for _ in range(60):
            watched.tick()
        if stopped:
            watched.stop(0.2 * watched.period)
        watched.world.advance()
        speeds[stopped] = watched.world.truth(0)["speed"]
    assert speeds[True] < speeds[False] - 0.05


def test_conditions_are_rows_of_the_core_with_the_loaded_cars_values() -> None:
    conditions = Conditions(load_car("nuc2"))
    car = load_car("nuc2").core
    for field in conditions.table.fields:
        if field.section in ("vehicle", "lidar", "sensors"):
            assert field.default == car.get(field.section, field.name) == conditions.get(field.key)
    assert conditions.set("delay_extra", 0.1) == "race.delay_extra"
    changed = conditions.car()
    assert changed.get("vehicle", "steering_delay") == pytest.approx(car.get("vehicle", "steering_delay") + 0.1)
    with pytest.raises(InputError, match=r"mu_scale is 7.*0\.05 to 3"):
        conditions.set("mu_scale", 7)
    with pytest.raises(InputError, match="unknown parameter 'fricton'"):
        conditions.set("fricton", 1)
    conditions.set("vehicle.steering_delay", 0.3)
    with pytest.raises(InputError, match=r"steering_delay is 0\.6"):
        conditions.set("delay_extra", 0.3)
    assert conditions.get("delay_extra") == 0.1


# SimSource, with its race process.


@pytest.fixture(scope="module")
def source() -> Iterator[SimSource]:
    """A fast race; every test leaves it driving."""
    made = SimSource(firstlap.load_track("arena"), load_setup("sure"), load_car("default"), pace=20.0)
    assert made.latest() is None
    made.start()
    yield made
    made.close()
    assert multiprocessing.active_children() == []


def test_frames_and_laps_come_from_the_other_process(source: SimSource) -> None:
    assert isinstance(source, Drives)
    assert isinstance(source, Simulates)
    frame = shown(source, lambda frame: len(frame.laps) > 0)
    assert frame.laps[0].time == pytest.approx(race(source.track, "sure", laps=1).laps[0].time, abs=0.03)
    later = shown(source, lambda one: one.number > frame.number + 20)
    assert later.time > frame.time
    assert later.pose is not None
    assert len(later.trace["points"]) > 1000
    assert later.step_us > 0.0
    assert 0.0 <= (later.distance or -1.0) < source.track.length
    assert source.scenery.bounds() is not None


def test_a_parameter_changes_the_running_driver(source: SimSource) -> None:
    shown(source, lambda frame: frame.may_drive and frame.speed > 2.5)
    source.change({"velocity_profile.v_max": 2.0})
    assert source.setup.get("v_max") == 2.0
    assert source.loaded.get("v_max") != 2.0
    shown(source, lambda frame: frame.trace["path"]["velocity"].max() <= 2.0 and frame.speed < 2.2)
    source.change({"v_max": source.loaded.get("v_max")})
    shown(source, lambda frame: frame.speed > 2.5)


def test_a_bad_value_is_refused_with_its_reason_and_the_race_goes_on(source: SimSource) -> None:
    before = source.setup
    with pytest.raises(InputError, match=r"velocity_profile.v_max is -1"):
        source.change({"v_max": -1.0, "k_ang": 0.5})
    with pytest.raises(InputError, match="v_min"):
        source.change({"v_min": 6.0, "v_max": 2.0})
    with pytest.raises(InputError, match=r"sensors\.latency"):
        source.set_condition("sensors.latency", 5.0)
    assert source.setup is before
    number = shown(source, lambda frame: frame.may_drive).number
    shown(source, lambda frame: frame.number > number + 5 and frame.may_drive)


@pytest.mark.parametrize("pace", [20.0, 1.0, 0.1])
def test_the_emergency_stop_counts_at_once_and_until_go(source: SimSource, pace: float) -> None:
    shown(source, lambda frame: frame.may_drive and frame.speed > 2.0)
    source.set_condition("pace", pace)
    asked = time.monotonic()
    source.stop()
    frame = shown(source, lambda frame: not frame.may_drive)
    assert time.monotonic() - asked < 0.3
    assert "emergency stop" in frame.message
    source.set_condition("pace", 20.0)
    stood = shown(source, lambda frame: abs(frame.speed) < 0.15 and frame.time > 1.0)
    still = shown(source, lambda frame: frame.time > stood.time + 2.0)
    assert not still.may_drive
    assert abs(still.distance - stood.distance) < 0.5  # type: ignore[operator]
    source.go()
    shown(source, lambda frame: frame.may_drive and frame.speed > 1.0)


def test_the_car_is_restarted_and_placed(source: SimSource) -> None:
    source.stop()
    source.restart()
    frame = shown(source, lambda frame: not frame.laps and abs(frame.speed) < 0.2 and frame.distance is not None)
    assert min(frame.distance, source.track.length - frame.distance) < 0.5  # type: ignore[operator, type-var]
    assert frame.lap_start is not None
    assert frame.time - frame.lap_start < 1.0
    there = source.track.start_pose(12.0)
    source.place(there)
    frame = shown(source, lambda frame: abs((frame.distance or 0.0) - 12.0) < 0.3)
    assert np.hypot(frame.pose[0] - there[0], frame.pose[1] - there[1]) < 0.3  # type: ignore[index]
    wall = source.track.walls[0][3]
    for pose, words in (
        ((wall[0], wall[1], 0.0), "touch a wall"),
        ((1e3, 0.0, 0.0), "not on the track"),
        ((float("nan"), 0.0, 0.0), "expected x, y"),
    ):
        with pytest.raises(InputError, match=words):
            source.place(pose)
    source.go()
    shown(source, lambda frame: frame.may_drive and frame.speed > 1.0)


def test_another_driver_takes_over(source: SimSource) -> None:
    source.choose(load_setup("gap"))
    frame = shown(source, lambda frame: frame.driver == "gap" and "free" in frame.trace)
    assert source.loaded.driver == "gap"
    shown(source, lambda one: one.number > frame.number + 5)
    with pytest.raises(InputError, match="nonsense"):
        source.change({"nonsense": 1.0})
    source.choose(load_setup("sure"))
    shown(source, lambda frame: frame.driver == "local")


def test_friction_is_changed_without_a_restart(source: SimSource) -> None:
    laps = len(shown(source, lambda frame: len(frame.laps) > 0).laps)
    source.set_condition("world.mu_scale", 0.15)
    frame = shown(source, lambda frame: "contact" in frame.message)
    assert len(frame.laps) >= laps
    source.set_condition("mu_scale", 1.0)
    source.restart()
    shown(source, lambda frame: frame.may_drive and frame.speed > 1.0)


def test_who_asks_for_nothing_holds_nothing_up(arena: firstlap.Track) -> None:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    their_life, life = context.Pipe(duplex=False)
    process = context.Process(target=run, args=(plan(arena), theirs, their_life), daemon=True)
    process.start()
    theirs.close()
    asks = 0
    ours.send(("ask", -1, 0))
    assert ours.poll(LONG)
    ours.recv()
    ours.send(("timing",))
    ours.recv()
    for _ in range(20):  # more than the pipe's buffer, without a reader
        ours.send(("ask", 0, 0))
        asks += 1
        time.sleep(0.03)
    ours.send(("timing",))
    frames = 0
    while (message := ours.recv())[0] == "frame":
        frames += 1
    assert 1 <= frames <= asks
    assert len(message[1]) >= 12, "at 40 Hz it would be 24"
    ours.close()  # the viewer's process has ended
    life.close()
    process.join(LONG)
    assert process.exitcode == 0


VIEWER = """
import sys, time
import firstlap
from firstlap.drivers.racer import step_core
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.pitwall.sim_source import SimSource

if __name__ == "__main__":
    source = SimSource(firstlap.load_track("arena"), load_setup("sure"), load_car("default"))
    source.start()
    while source.latest() is None:
        time.sleep(0.01)
    print(source._race.process.pid, flush=True)
    time.sleep(60)
"""


def _lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_race_ends_with_the_process_that_shows_it(tmp_path: Path) -> None:
    script = tmp_path / "viewer.py"
    script.write_text(VIEWER)
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as viewer:
        assert viewer.stdout is not None
        pid = int(viewer.stdout.readline())
        assert _lives(pid)
        viewer.kill()
        viewer.wait()
        wait(lambda: not _lives(pid))


def test_a_race_that_hangs_is_said_and_goes_on_where_it_was(source: SimSource) -> None:
    shown(source, lambda frame: frame.may_drive)
    assert source._race is not None
    pid = source._race.process.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    try:
        frame = shown(source, lambda frame: "does not respond" in frame.message)
        source.stop()
    finally:
        os.kill(pid, signal.SIGCONT)
    shown(source, lambda one: one.number > frame.number and "emergency stop" in one.message)
    source.go()
    shown(source, lambda frame: frame.may_drive and frame.speed > 1.0)


def test_a_race_whose_process_died_says_so_and_begins_anew(source: SimSource) -> None:
    assert source._race is not None
    pid = source._race.process.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    frame = shown(source, lambda frame: "has ended" in frame.message)
    assert "signal 9" in frame.message
    assert not frame.may_drive
    source.stop()
    with pytest.raises(InputError, match="restart"):
        source.change({"k_ang": 0.3})
    source.go()
    source.restart()
    again = shown(source, lambda one: one.number > frame.number + 5)
    assert again.may_drive
    assert "ended" not in again.message


# A recording.


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A recording of two laps of arena."""
    path = tmp_path_factory.mktemp("recording") / "race.mcap"
    race(firstlap.load_track("arena"), "sure", laps=2, record=path)
    return load_recording(path)


@pytest.fixture
def played(recording: Recording) -> Iterator[RecordingSource]:
    """A source, paused at its first scan."""
    made = RecordingSource(recording, load_setup("sure"), load_car("default"))
    made.pause()
    made.start()
    made.pause()
    made.seek(0)
    shown(made, lambda frame: frame.time == 0.0)
    yield made
    made.close()


def fresh(recording: Recording, setup: Setup, scan: int) -> dict[str, Any]:
    """The trace of a driver with this setup for the scan, after the previous seconds."""
    racer = firstlap.Racer(setup, load_car("default"))
    for i in range(begin_of_memory(recording, scan), scan + 1):
        step_core(racer.core, recording.scan(i), recording.state(i), float(recording.dts[i]))
    return racer.trace


def same_plan(one: Any, other: Any) -> bool:
    return bool(
        one["result"] == other["result"]
        and np.array_equal(one["path"]["x"], other["path"]["x"])
        and np.array_equal(one["path"]["velocity"], other["path"]["velocity"])
    )


def test_a_recording_is_wound_to_any_scan(played: RecordingSource, recording: Recording) -> None:
    assert isinstance(played, Plays)
    assert not isinstance(played, Drives)
    for scan in (len(recording) - 1, 3, 500, 499):
        played.seek(scan)
        frame = shown(played, lambda frame, scan=scan: frame.time == recording.stamps[scan])  # type: ignore[misc]
        assert played.scan == scan
        assert np.allclose(frame.pose, recording.poses[scan])  # type: ignore[arg-type, index]
        assert same_plan(frame.trace, fresh(recording, played.setup, scan))
    played.seek(10**9)
    shown(played, lambda frame: frame.time == recording.stamps[-1])
    played.seek(-5)
    shown(played, lambda frame: frame.time == 0.0)


def test_a_recording_plays_at_its_pace_and_stands_when_paused(played: RecordingSource, recording: Recording) -> None:
    played.seek(400)
    shown(played, lambda frame: frame.time == recording.stamps[400])
    played.set_pace(2.0)
    played.play()
    begin = time.monotonic()
    shown(played, lambda frame: frame.time >= recording.stamps[440])
    assert time.monotonic() - begin > 0.4
    played.pause()
    stood = shown(played, lambda frame: frame.time == recording.stamps[played.scan])
    time.sleep(0.1)
    assert played.latest() is stood
    with pytest.raises(InputError, match=r"0\.1 to 20"):
        played.set_pace(100.0)
    played.seek(len(recording) - 5)
    played.play()
    wait(lambda: not played.playing)
    assert shown(played, lambda frame: frame.time == recording.stamps[-1])
    played.play()
    shown(played, lambda frame: frame.time < 1.0)


def test_a_changed_parameter_plans_the_same_scan_anew(played: RecordingSource, recording: Recording) -> None:
    played.seek(300)
    loaded = shown(played, lambda frame: frame.time == recording.stamps[300])
    assert loaded.before is None
    played.change({"v_max": 2.5, "k_ang": 0.6})
    tried = shown(played, lambda frame: frame.number > loaded.number)
    assert tried.time == loaded.time
    assert not same_plan(tried.trace, loaded.trace)
    assert same_plan(tried.trace, fresh(recording, played.setup, 300))
    assert tried.before is not None
    assert same_plan(tried.before, loaded.trace)
    with pytest.raises(InputError, match="v_max"):
        played.change({"v_max": -1.0})
    played.seek(301)
    after = shown(played, lambda frame: frame.time == recording.stamps[301])
    assert after.before is not None
    assert not same_plan(after.trace, after.before)
    played.choose(played.loaded)
    shown(played, lambda frame: frame.before is None and frame.number > after.number)


def test_another_driver_looks_at_the_recording(played: RecordingSource) -> None:
    played.choose(load_setup("disparity"))
    frame = shown(played, lambda frame: frame.driver == "disparity")
    assert "extended" in frame.trace
    with pytest.raises(InputError, match="needs a map"):
        played.choose(load_setup("global"))
    assert played.setup.driver == "disparity"


def test_laps_of_a_recording_come_from_its_poses(played: RecordingSource, recording: Recording) -> None:
    raced = race(firstlap.load_track("arena"), "sure", laps=2)
    played.seek(0)
    assert shown(played, lambda frame: frame.time == 0.0).laps == ()
    played.seek(len(recording) - 1)
    (lap, *_) = shown(played, lambda frame: frame.time == recording.stamps[-1]).laps
    assert lap.standing
    assert lap.time == pytest.approx(raced.laps[0].time, abs=0.6)
    assert np.hypot(*np.diff(lap.line, axis=0).T).sum() == pytest.approx(raced.laps[0].distance, rel=0.03)


# The command.


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "expected a track, a recording, or --ros"),
        (("aren",), "did you mean arena"),
        (("gone.mcap",), "gone.mcap: no such recording"),
        (("arena", "--speed", "1"), "--speed: has no effect with a track"),
        (("arena", "--pace", "0"), "0.1 to 20"),
        (("arena", "--set", "v_max=-1"), "v_max is -1"),
        (("arena", "--ros"), "has no effect with --ros"),
        (("empty.npz",), "is empty"),
        (("damaged.mcap",), "damaged.mcap"),
        (("damaged.npz", "--seed", "1"), "--seed: has no effect with a recording"),
        (("damaged.npz",), "damaged.npz"),
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(
    cli: Callable[..., CommandResult], arguments: tuple[str, ...], words: str
) -> None:
    pytest.importorskip("viser")
    Path("empty.npz").touch()
    for name in ("damaged.mcap", "damaged.npz"):
        Path(name).write_bytes(b"nothing of that kind" * 10)
    ran = cli("view", *arguments, "--no-open")
    assert ran.code == 2
    assert words in ran.err
    assert ran.err.count("\n") == 1


def test_without_a_wish_the_next_free_port_is_taken(capsys: pytest.CaptureFixture[str]) -> None:
    taken = []
    try:
        for port in (view.PORT, view.PORT + 1):
            with contextlib.suppress(OSError):
                taken.append(socket.create_server(("127.0.0.1", port)))
        found = view.choose_port("127.0.0.1", None)
        assert found > view.PORT + 1
        assert f"port {view.PORT} is in use: using {found}" in " ".join(capsys.readouterr().err.split())
        assert view.choose_port("127.0.0.1", view.PORT) == view.PORT, "whoever names a port is told that it is taken"
    finally:
        for server in taken:
            server.close()


def test_the_command_serves_until_ctrl_c(cli: Callable[..., CommandResult], tmp_path: Path) -> None:
    pytest.importorskip("viser")
    command = [sys.executable, "-c", "from firstlap_command import main; main()", "view"]
    with subprocess.Popen(
        [*command, "arena", "--port", "0", "--no-open"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip()
            with urllib.request.urlopen(address, timeout=LONG) as page:
                assert page.status == 200
            port = address.rstrip("/").rpartition(":")[2]
            taken = cli("view", "arena", "--port", port, "--no-open")
            assert taken.code == 2
            assert f"port {port} is in use" in taken.err
            process.send_signal(signal.SIGINT)
            _, output = process.communicate(timeout=LONG)
        finally:
            process.kill()
        assert process.returncode == 0, output
        assert "Traceback" not in output
        assert "leaked" not in output


def test_after_a_stop_the_race_shows_the_command_that_is_sent(arena: firstlap.Track) -> None:
    race = sim_race(arena)
    for _ in range(120):
        race.tick()
    assert race.frame().sent is None
    race.stop()
    for _ in range(4):
        race.tick()
    frame = race.frame()
    assert frame.trace["result"][0] > 0.0  # the driver itself still commands a speed
    assert frame.sent is not None and frame.sent[0] == 0.0
    race.go()
    assert race.frame().sent is None


def test_a_simulated_car_may_have_another_lidar_and_a_recording_has_its_own(
    cli: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    served: list[Any] = []
    monkeypatch.setattr("firstlap.cli.view._serve", lambda source, *_: served.append(source) or 0)
    assert cli("view", "oval", "--lidar", "ld19", "--no-open").code == 0
    lidar = served[0].car.core.values()["lidar"]
    assert (served[0].car.name, lidar["beams"]) == ("default with ld19", 455)
    assert cli("race", "oval", "--laps", 1, "--record", "race.mcap").code == 0
    ran = cli("view", "race.mcap", "--lidar", "ld19", "--no-open")
    assert (ran.code, ran.err) == (2, "error: --lidar: has no effect with a recording\n")
