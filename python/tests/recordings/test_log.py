"""Logs of races and replays: standard messages, whose replay gives the same commands."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import bags
import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from waiting import PATIENCE

import firstlap
from firstlap.common.errors import InputError
from firstlap.evaluation.replay.replay import replay
from firstlap.recordings import load_recording
from firstlap.recordings import log_messages as ros
from firstlap.recordings.messages import typestore
from firstlap.recordings.trace_tables import TABLES, TRAJECTORY
from firstlap.recordings.write import TOPICS

EXTRA = {"/scan", "/odom", "/joint_states", "/drive", "/tf", "/tf_static", "/ground_truth/odom"}


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> tuple[firstlap.RaceResult, Path]:
    """A race of one lap with its log."""
    path = tmp_path_factory.mktemp("log") / "race.mcap"
    setup = firstlap.load_setup("sure").with_values({"k_ang": 0.6180339887498949, "v_max": 4.1})
    return firstlap.race(firstlap.load_track("oval"), setup, laps=1, seed=5, record=path), path


def test_a_log_changes_nothing_in_the_race(logged):
    result, _ = logged
    plain = firstlap.race(result.track, result.setup, laps=1, seed=5)
    assert result.laps == plain.laps
    assert all(np.array_equal(result.path[name], plain.path[name]) for name in plain.path)


def test_a_race_replays_to_the_same_commands_bit_for_bit(logged):
    result, path = logged
    recording = load_recording(path)
    assert recording.remarks == ()
    assert recording.about is not None
    driven = replay(recording, recording.about.setup, recording.about.car).driven
    assert np.array_equal(driven.speed, result.path["command_speed"])
    assert np.array_equal(driven.steering_angle, result.path["command_steering_angle"])
    assert np.array_equal(driven.status, result.path["status"])
    assert recording.commands is not None
    assert np.array_equal(driven.speed.astype(np.float32), recording.commands.speed)
    assert np.array_equal(driven.steering_angle.astype(np.float32), recording.commands.steering_angle)


def test_a_car_whose_period_is_no_whole_number_of_nanoseconds_replays_too(tmp_path):
    car = tmp_path / "car.yaml"
    car.write_text("lidar:\n  rate: 30\n  beams: 541\n  sweep_time: 0.017\nsensors:\n  latency: 0.013\n")
    loaded = firstlap.load_car(car)
    path = tmp_path / "a.mcap"
    result = firstlap.race(firstlap.load_track("oval"), "base", loaded, laps=1, record=path)
    recording = load_recording(path)
    assert recording.about is not None
    driven = replay(recording, recording.about.setup, recording.about.car).driven
    assert np.array_equal(driven.steering_angle, result.path["command_steering_angle"])


@pytest.mark.parametrize("driver", ["gap", "disparity", "pid"])
def test_races_of_every_driver_replay_to_the_same(tmp_path, driver):
    path = tmp_path / "a.mcap"
    result = firstlap.race(firstlap.load_track("oval"), driver=driver, laps=1, record=path)
    recording = load_recording(path)
    assert recording.about is not None
    driven = replay(recording, recording.about.setup, recording.about.car).driven
    assert np.array_equal(driven.steering_angle, result.path["command_steering_angle"])


def test_a_race_whose_driver_skips_scans_replays_to_the_same(tmp_path):
    path = tmp_path / "a.mcap"
    result = firstlap.race(firstlap.load_track("oval"), "base", laps=1, latency="fixed:60", record=path)
    recording = load_recording(path)
    assert result.skipped_scans > 100
    assert recording.dts.max() > 0.049
    assert len(recording) + result.skipped_scans == pytest.approx(len(result.path["time"]), abs=1)
    assert recording.about is not None
    assert recording.commands is not None
    assert recording.poses is not None
    driven = replay(recording, recording.about.setup, recording.about.car).driven
    assert np.array_equal(driven.steering_angle.astype(np.float32), recording.commands.steering_angle)
    assert np.array_equal(driven.speed.astype(np.float32), recording.commands.speed)
    # Every scan's pose is the true one at its time.
    numbers = np.round((recording.start + recording.stamps) / 0.025).astype(int) - 1
    assert np.allclose(recording.poses[:, 0], result.path["x"][numbers], atol=1e-12)


def test_the_log_of_a_replay_replays_to_the_same(tmp_path):
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", bags.entries(80))).between(0.3, None)
    first = replay(recording, firstlap.load_setup("race"), firstlap.load_car("nuc2"), record=tmp_path / "a.mcap")
    again = load_recording(tmp_path / "a.mcap")
    assert again.about is not None
    assert again.about.car.name == "nuc2"
    second = replay(again, again.about.setup, again.about.car)
    assert np.array_equal(first.driven.speed, second.driven.speed)
    assert np.array_equal(first.driven.steering_angle, second.driven.steering_angle)
    assert again.start == pytest.approx(recording.start + 0.3)


def test_the_command_line_replays_a_log_with_its_own_setup_and_says_so(cli):
    assert "log: a.mcap" in cli("race", "oval", "--setup", "base", "--laps", 1, "--record", "a.mcap").out
    ran = cli("replay", "a.mcap", "--json", "--record", "b.mcap")
    assert ran.code == 0
    assert ran.json["setup"] == "base"
    assert ran.json["recorded"]["steering_angle"]["p95"] < 1e-7
    assert "setup base, from the log" in ran.json["remarks"]
    assert len(load_recording("b.mcap")) == ran.json["scans"]
    other = cli("replay", "a.mcap", "--setup", "race", "--json").json
    assert other["setup"] == "race"
    assert other["recorded"]["steering_angle"]["p95"] > 1e-3


def test_another_programs_reader_finds_standard_messages(logged):
    result, path = logged
    scans = len(result.path["time"])
    with path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())
    store = get_typestore(Stores.EMPTY)
    with Reader(path) as reader:
        assert {connection.topic: connection.msgtype for connection in reader.connections} == TOPICS
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        seen: dict[str, list[object]] = {}
        for connection, _, data in reader.messages():
            seen.setdefault(connection.topic, []).append(store.deserialize_cdr(data, connection.msgtype))
    assert {topic: len(seen[topic]) for topic in EXTRA - {"/tf_static"}} == dict.fromkeys(EXTRA - {"/tf_static"}, scans)
    assert len(seen["/firstlap/walls"]) == 2 * scans
    truth = np.array([(m.pose.pose.position.x, m.pose.pose.position.y) for m in seen["/ground_truth/odom"]])
    assert np.array_equal(truth, np.column_stack([result.path["x"], result.path["y"]]))
    assert [m.transforms[0].child_frame_id for m in seen["/tf_static"]] == ["laser"]
    assert seen["/tf_static"][0].transforms[0].transform.translation.x == 0.27
    # A scan is stamped at its first beam, 18.75 ms before its last, to which all other data belong.
    sweep = 1080 * seen["/scan"][0].time_increment
    assert sweep == pytest.approx(0.01875)
    for message, odometry in zip(seen["/scan"], seen["/odom"], strict=True):
        first, last = ((m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec) for m in (message, odometry))
        assert last - first == pytest.approx(sweep, abs=2e-9)
        assert message.scan_time == pytest.approx(0.025)
    # The composition of a scan's two transforms is the true pose.
    for message, x, y in list(zip(seen["/tf"], result.path["x"], result.path["y"], strict=True))[::50]:
        odom, base = (t.transform for t in sorted(message.transforms, key=lambda t: t.header.frame_id))
        yaw = 2.0 * np.arctan2(odom.rotation.z, odom.rotation.w)
        c, s = np.cos(yaw), np.sin(yaw)
        found = (
            odom.translation.x + c * base.translation.x - s * base.translation.y,
            odom.translation.y + s * base.translation.x + c * base.translation.y,
        )
        assert found == pytest.approx((x, y), abs=1e-9)
    clouds = [np.frombuffer(m.data.tobytes(), dtype=TRAJECTORY.dtype) for m in seen["/firstlap/trajectory"]]
    paths = [[(p.pose.position.x, p.pose.position.y) for p in m.poses] for m in seen["/firstlap/path"]]
    assert all(
        np.allclose(np.column_stack([cloud["x"], cloud["y"]]), path) for cloud, path in zip(clouds, paths, strict=True)
    )
    assert max(cloud["velocity"].max() for cloud in clouds) < 4.5
    assert all((np.diff(cloud["s"]) > 0.0).all() for cloud in clouds)


def test_a_template_gives_what_the_library_gives():
    rows = np.random.default_rng(1).normal(size=(7, 3))
    now = 1_700_000_000_123_456_789
    poses = [
        ros.make(
            "geometry_msgs/msg/PoseStamped",
            ros.stamped(now, "base_link"),
            ros.make(
                "geometry_msgs/msg/Pose",
                ros.make("geometry_msgs/msg/Point", x, y, 0.0),
                ros.make("geometry_msgs/msg/Quaternion", 0.0, 0.0, np.sin(0.5 * yaw), np.cos(0.5 * yaw)),
            ),
        )
        for x, y, yaw in rows.tolist()
    ]
    for count in (0, 1, 2, 3, 7):
        message = ros.make(ros.PATH, ros.stamped(now, "base_link"), poses[:count])
        assert ros.path(now, rows[:count]) == bytes(typestore().serialize_cdr(message, ros.PATH))
        wall = typestore().deserialize_cdr(ros.wall(now, "left", rows[:count]), ros.MARKER)
        assert [(point.x, point.y) for point in wall.points] == [(x, y) for x, y, _ in rows[:count].tolist()]
        assert bytes(typestore().serialize_cdr(wall, ros.MARKER)) == ros.wall(now, "left", rows[:count])


@pytest.mark.parametrize("frame", ["", "b", "car1/base_link"])
@pytest.mark.parametrize("count", [0, 1, 6])
def test_clouds_and_diagnostics_are_what_the_library_writes(frame, count):
    now = 1_700_000_000_123_456_789
    for table in (table for tables in TABLES.values() for table in tables):
        rows = np.frombuffer(np.random.default_rng(count).bytes(count * table.dtype.itemsize), table.dtype)
        written = ros.cloud(now, rows, frame)
        message = typestore().deserialize_cdr(written, ros.CLOUD)
        assert bytes(typestore().serialize_cdr(message, ros.CLOUD)) == written
        assert (message.width, message.height, message.header) == (count, 1, ros.stamped(now, frame))
        assert [field.name for field in message.fields] == list(table.dtype.names or ())
        assert bytes(message.data) == rows.tobytes()
    values = {"k" * i: "ü" * i for i in range(count)}
    written = ros.diagnostics(now, [ros.Diagnosis("a", "bc", ros.WARN, values), ros.diagnosis("ok")], frame)
    message = typestore().deserialize_cdr(written, ros.DIAGNOSTICS)
    assert bytes(typestore().serialize_cdr(message, ros.DIAGNOSTICS)) == written
    assert {one.key: one.value for one in message.status[0].values} == values
    assert [(one.name, one.message, one.level) for one in message.status] == [("a", "bc", 1), ("firstlap", "ok", 0)]


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_the_log_of_a_killed_race_is_readable(tmp_path):
    path = tmp_path / "a.mcap"
    command = [sys.executable, "-c", "from firstlap.cli import main; main()", "race", "oval", "--laps", "100000"]
    process = subprocess.Popen([*command, "--record", str(path)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + PATIENCE
        while (not path.exists() or path.stat().st_size < 500_000) and time.monotonic() < deadline:
            time.sleep(0.05)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == -signal.SIGKILL
    recording = load_recording(path)
    assert len(recording) > 20
    assert "unfinished" in " ".join(recording.remarks)
    assert recording.about is not None
    driven = replay(recording, recording.about.setup, recording.about.car).driven
    assert recording.commands is not None
    assert np.array_equal(driven.steering_angle.astype(np.float32), recording.commands.steering_angle)


def test_a_log_that_is_cut_off_anywhere_replays_to_the_commands_in_it(logged, tmp_path):
    data, path = logged[1].read_bytes(), tmp_path / "cut.mcap"
    lengths, left_out = set(), 0
    for share in np.linspace(0.05, 0.95, 80):
        path.write_bytes(data[: int(share * len(data))])
        recording = load_recording(path)
        assert recording.about is not None
        assert recording.commands is not None
        driven = replay(recording, recording.about.setup, recording.about.car).driven
        assert np.array_equal(driven.speed.astype(np.float32), recording.commands.speed)
        assert np.array_equal(driven.steering_angle.astype(np.float32), recording.commands.steering_angle)
        lengths.add(len(recording))
        left_out += "the scan was dropped" in " ".join(recording.remarks)
    assert len(lengths) > 20
    assert left_out > 0


def test_an_interrupted_race_leaves_a_finished_log(tmp_path):
    def stop(running: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        firstlap.race(firstlap.load_track("oval"), "base", laps=50, on_progress=stop, record=tmp_path / "a.mcap")
    recording = load_recording(tmp_path / "a.mcap")
    assert len(recording) == 40
    assert recording.remarks == ()


def test_a_log_that_cannot_be_written_is_one_line(cli, tmp_path):
    assert "a.txt" in cli("race", "oval", "--record", "a.txt").err
    assert "no such folder" in cli("race", "oval", "--record", "no/a.mcap").err
    if not Path("/dev/full").exists():
        pytest.skip("no device that is full")
    (tmp_path / "full.mcap").symlink_to("/dev/full")
    ran = cli("race", "oval", "--setup", "base", "--laps", 1, "--record", "full.mcap")
    assert ran.code == 2
    assert ran.err == "error: full.mcap: cannot be written (No space left on device); the log ends there\n"


def test_a_log_whose_own_record_is_broken_is_still_a_recording(tmp_path):
    from mcap.writer import Writer

    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start("ros2")
        writer.add_metadata("firstlap", {"setup": "{}", "car": "nonsense"})
        schema = writer.register_schema(bags.SCAN, "ros2msg", b"")
        channel = writer.register_channel("/scan", "cdr", schema)
        for entry in bags.entries(20, odom=False, commands=False):
            data = bytes(typestore().serialize_cdr(entry.message, bags.SCAN))
            writer.add_message(channel, entry.time, data, entry.time)
        writer.finish()
    recording = load_recording(tmp_path / "a.mcap")
    assert len(recording) == 20
    assert recording.about is None
    assert "its record 'firstlap' cannot be read" in " ".join(recording.remarks)


def test_reading_raises_input_errors_alone():
    with pytest.raises(InputError, match="no such file or folder"):
        load_recording("nowhere.mcap")


def test_python_of_the_document(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).resolve().parents[3] / "docs" / "recordings.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, "recordings.md", "exec"), {})
    assert len(load_recording("race.mcap")) > 100


def test_the_document_names_every_topic():
    text = (Path(__file__).resolve().parents[3] / "docs" / "recordings.md").read_text(encoding="utf-8")
    for topic, kind in TOPICS.items():
        assert f"`{topic}`" in text
        assert f"`{kind.replace('/msg/', '/')}`" in text


def test_a_race_waits_for_its_log_rather_than_lose_a_scan(tmp_path, monkeypatch):
    monkeypatch.setattr("firstlap.recordings.write.WAITING", 30)
    result = firstlap.race(firstlap.load_track("oval"), "base", laps=1, record=tmp_path / "a.mcap")
    assert len(load_recording(tmp_path / "a.mcap")) == len(result.path["time"])


def test_ackermann_is_the_type_that_ros_2_knows():
    published = "RIHS01_48ca7612a08d3bb72744fd98b71b7cf2ea24c6ad50fa4e1aa0bbad963c90d8cf"
    assert typestore().hash_rihs01(ros.DRIVE) == published
