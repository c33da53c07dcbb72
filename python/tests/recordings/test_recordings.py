"""Recordings: equal results for all formats, selection of topics, and damaged files."""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable
from pathlib import Path

import bags
import numpy as np
import pytest
import zstandard
from rosbags.rosbag2 import CompressionMode

from firstlap.common.errors import InputError
from firstlap.perception.scan import Judgment
from firstlap.recordings import Recording, Topics, load_recording
from firstlap.recordings.laser import parse_laser
from firstlap.recordings.scans import USABLE, Findings

SCANS = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "scans"
needs_scans = pytest.mark.skipif(not SCANS.is_dir(), reason="the real recordings (../shared/data) are not here")


def remarks(recording: Recording) -> str:
    """All remarks in one line."""
    return " | ".join(recording.remarks)


@pytest.mark.parametrize("write", bags.WRITERS.values(), ids=bags.WRITERS.keys())
def test_every_format_gives_the_same(tmp_path, write):
    recording = load_recording(write(tmp_path))
    assert len(recording) == 60
    assert recording.remarks == ()
    assert all(np.array_equal(one, bags.corridor(seed=i)) for i, one in enumerate(recording.ranges))
    assert recording.stamps == pytest.approx(np.arange(60) * bags.PERIOD, abs=1e-12)
    assert np.all(recording.dts == bags.PERIOD)
    assert np.all(recording.states == [bags.SPEED, 0.01, np.float64(np.float32(0.05))])
    assert recording.sources["speed"] == "odometry (/odom)"
    assert recording.sources["steering_angle"] == "commands (/drive)"
    assert recording.commands is not None
    assert np.all(recording.commands.speed == bags.SPEED)
    assert recording.poses is not None
    assert recording.poses[-1, 0] == pytest.approx(59 * bags.PERIOD * bags.SPEED)
    assert recording.headers[0, :2] == pytest.approx([-0.75 * np.pi, 1.5 * np.pi / 270], rel=1e-6)


def test_without_odometry_the_speed_is_the_commanded_one_and_that_is_said(tmp_path):
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", bags.entries(odom=False)))
    assert np.all(recording.speed == bags.SPEED)
    assert recording.sources["speed"] == "commands (/drive)"
    assert "no odometry: the commanded speed is used, from /drive" in remarks(recording)
    assert "no yaw rate" in remarks(recording)
    assert recording.yaw_rate == pytest.approx(np.full(60, bags.SPEED * np.tan(0.05) / 0.33))


def test_without_anything_the_speed_is_the_one_given_and_that_is_said(tmp_path):
    path = bags.write_rosbag2(tmp_path / "a", bags.entries(odom=False, commands=False))
    recording = load_recording(path, Topics(speed=2.5))
    assert np.all(recording.speed == 2.5)
    assert "a speed of 2.5 m/s is assumed" in remarks(recording)


def test_an_imu_turns_where_odometry_does_not_or_where_it_is_named(tmp_path):
    scans = bags.entries(odom=False, commands=False)
    turning = [bags.Entry("/imu", bags.IMU, bags.nanoseconds(i), bags.imu(bags.nanoseconds(i), 0.5)) for i in range(60)]
    still = [
        bags.Entry("/odom", bags.ODOM, bags.nanoseconds(i), bags.odometry(bags.nanoseconds(i), 1.0)) for i in range(60)
    ]
    moving = [entry for entry in bags.entries() if entry.topic == "/odom"]
    one = load_recording(bags.write_rosbag2(tmp_path / "a", scans + turning + still))
    assert np.all(one.yaw_rate == 0.5)
    path = bags.write_rosbag2(tmp_path / "b", scans + turning + moving)
    assert np.all(load_recording(path).yaw_rate == 0.01)
    assert np.all(load_recording(path, Topics(imu="/imu")).yaw_rate == 0.5)


def test_of_several_topics_the_usual_one_is_taken_and_that_is_said(tmp_path):
    more = [entry._replace(topic=f"{entry.topic}_2") for entry in bags.entries()]
    path = bags.write_rosbag2(tmp_path / "a", bags.entries() + more)
    recording = load_recording(path)
    assert recording.topics == {"scan": "/scan", "odom": "/odom", "drive": "/drive"}
    assert "of 2 LaserScan topics, /scan is used, not /scan_2: see --scan-topic" in remarks(recording)
    recording = load_recording(path, Topics(scan="/scan_2", odom="odom_2", drive="none"))
    assert recording.topics == {"scan": "/scan_2", "odom": "/odom_2"}
    assert recording.commands is None
    assert "is used, not" not in remarks(recording)
    with pytest.raises(InputError, match="/nowhere"):
        load_recording(path, Topics(scan="/nowhere"))


def test_where_no_name_is_usual_all_choices_are_asked_for_at_once(tmp_path):
    both = [entry._replace(topic=f"/car{car}{entry.topic}") for car in (1, 2) for entry in bags.entries()]
    path = bags.write_rosbag2(tmp_path / "a", both)
    with pytest.raises(InputError) as error:
        load_recording(path)
    for kind, name in (("LaserScan", "scan"), ("Odometry", "odom"), ("AckermannDriveStamped", "drive")):
        assert f"2 {kind} topics: /car1/{name}, /car2/{name}; choose one with --{name}-topic" in str(error.value)
    recording = load_recording(path, Topics(scan="/car1/scan", odom="/car1/odom", drive="/car1/drive"))
    assert len(recording) == 60


@pytest.mark.parametrize(
    ("stack", "taken"),
    [
        ("F1TENTH_SYSTEM", {"odom": "/odom", "imu": "/sensors/imu/raw", "drive": "/ackermann_drive"}),
        (
            "RACE_STACK",
            {
                "odom": "/car_state/odom",
                "imu": "/imu/data",
                "drive": "/vesc/low_level/ackermann_cmd_mux/output",
                "pose": "/car_state/pose",
            },
        ),
    ],
)
def test_what_the_usual_stacks_record_plays_without_options(tmp_path, stack, taken):
    topics = getattr(bags, stack)
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", bags.stack(topics)))
    assert recording.topics == {"scan": "/scan", **taken}
    names = list(topics)
    assert recording.speed == pytest.approx(np.full(60, bags.SPEED + 0.01 * names.index(taken["odom"])))
    assert recording.steering_angle == pytest.approx(np.full(60, 0.01 * names.index(taken["drive"])))
    assert recording.frame == ("map" if "pose" in taken else "laser")
    assert recording.laser == pytest.approx((0.27, 0.0, 0.0, False))
    assert recording.sources["laser"] == "/tf_static (base_link to laser)"
    for name in (taken["odom"], taken["drive"]):
        if sum(kind == topics[name] for kind in topics.values()) > 1:
            assert f"{name} is used" in remarks(recording)
    assert "/initialpose" not in remarks(recording)


def laser_bag(path: Path, transform: object, topic: str = "/tf_static", frame: str = "laser") -> Path:
    """A corridor with one transform and scans in `frame`."""
    items = bags.entries()
    for item in items:
        if item.topic == "/scan":
            item.message.header.frame_id = frame
    return bags.write_rosbag2(path, [bags.Entry(topic, bags.TF, bags.nanoseconds(0), transform), *items])


@pytest.mark.parametrize("topic", ["/tf_static", "/tf", "/car1/tf_static"])
def test_the_lasers_mounting_comes_from_the_frame_tree(tmp_path, topic):
    upside_down = bags.mounted(0.2, 0.03, 0.5 * np.pi, np.pi)
    recording = load_recording(laser_bag(tmp_path / "a", upside_down, topic))
    assert recording.laser == pytest.approx((0.2, 0.03, 0.5 * np.pi, True))
    step = 1.5 * np.pi / 270
    # Upside down, its first beam points to the car's left instead of right; all beams are rotated by 90 degrees.
    assert recording.headers[0, :2] == pytest.approx([0.75 * np.pi + 0.5 * np.pi, -step], rel=1e-6)
    assert "LiDAR mounting: 0.2 m ahead and 0.03 m left of base_link, rotated by 90°, upside down, from /tf" in (
        remarks(recording)
    )


def test_the_base_may_be_called_as_odometry_calls_it(tmp_path):
    items = [
        bags.Entry("/tf_static", bags.TF, 0, bags.mounted(0.2, 0.0, 0.0, parent="ego/base_link", child="ego/laser")),
        *bags.entries(),
    ]
    for item in items:
        if item.topic == "/odom":
            item.message.child_frame_id = "ego/base_link"
        if item.topic == "/scan":
            item.message.header.frame_id = "ego/laser"
    assert load_recording(bags.write_rosbag2(tmp_path / "a", items)).laser == pytest.approx((0.2, 0.0, 0.0, False))


def test_a_laser_that_nobody_places_or_that_a_person_places(tmp_path):
    path = laser_bag(tmp_path / "a", bags.mounted(0.2, 0.0, np.pi), frame="another")
    unknown = load_recording(path)
    assert unknown.laser is None
    assert "no transform from base_link to another: the LiDAR mounting of the car's parameters is assumed" in (
        remarks(unknown)
    )
    assert unknown.sources["laser"] == "the car's parameters"
    assert unknown.headers[0, 0] == pytest.approx(-0.75 * np.pi)
    given = load_recording(path, Topics(laser=parse_laser("0.1,0,-90")))
    assert given.laser == pytest.approx((0.1, 0.0, -0.5 * np.pi, False))
    assert given.headers[0, 0] == pytest.approx(-1.25 * np.pi)
    assert given.sources["laser"] == "--laser"


def test_a_laser_that_leans_is_refused_with_what_would_be_right(tmp_path):
    path = laser_bag(tmp_path / "a", bags.mounted(0.2, 0.0, 0.0, 0.5 * np.pi))
    with pytest.raises(InputError, match=r"is tilted by 90 degrees, by /tf_static .base_link to laser.; .* --laser"):
        load_recording(path)
    assert load_recording(path, Topics(laser=parse_laser("0.2,0,0"))).laser is not None


@pytest.mark.parametrize("text", ["", "1", "0.2,0", "0.2,0,nan", "0.2,0,0,45", "9,0,0", "a,b,c", "0.2,0,0,180,1"])
def test_a_laser_that_makes_no_sense_is_refused(text):
    with pytest.raises(InputError, match="--laser"):
        parse_laser(text)


def test_the_lasers_option_in_degrees():
    assert parse_laser("0.27,-0.02,180") == pytest.approx((0.27, -0.02, np.pi, False))
    assert parse_laser("0.27, 0, 90, 180") == pytest.approx((0.27, 0.0, 0.5 * np.pi, True))
    assert parse_laser("0,0,0,-180").upside_down


@pytest.mark.parametrize("factor", [180.0 / np.pi, 200.0])
def test_steering_in_degrees_or_percent_is_said_and_not_used(tmp_path, factor):
    items = bags.entries()
    for item in items:
        if item.topic == "/drive":
            item.message.drive.steering_angle = 0.05 * factor
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert "60 of 60 steering angles of /drive are above 1 rad" in remarks(recording)
    assert "degrees or percent instead of radians; all were dropped" in remarks(recording)
    assert recording.sources["steering_angle"] == "none"
    assert np.all(recording.steering_angle == 0.0)
    assert recording.commands is not None
    assert np.all(np.isnan(recording.commands.steering_angle))
    assert np.all(recording.commands.speed == bags.SPEED)


def test_a_single_angle_that_no_car_steers_is_dropped(tmp_path):
    items = bags.entries(200)
    items[-1].message.drive.steering_angle = 3.0
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert "1 of 200 steering angles of /drive are above 1 rad: these were dropped" in remarks(recording)
    assert recording.steering_angle == pytest.approx(np.full(200, 0.05))


def test_steering_of_a_numpy_file_in_degrees_is_not_used_either(tmp_path):
    good = {"ranges": np.ones((5, 271), dtype=np.float32), "angle_min": -2.3, "angle_increment": 0.017}
    np.savez(tmp_path / "a.npz", **good, speed=np.full(5, 2.0), steer=np.full(5, 12.0))
    recording = load_recording(tmp_path / "a.npz")
    assert "5 of 5 steering angles of steer are above 1 rad" in remarks(recording)
    assert recording.sources["steering_angle"] == "none"


def shifted(items: list[bags.Entry], topic: str, by: int) -> list[bags.Entry]:
    """The messages with the stamps of a topic on another clock, [ns] later."""
    for item in items:
        if item.topic == topic:
            stamp = item.message.header.stamp
            stamp.sec, stamp.nanosec = divmod(stamp.sec * 1_000_000_000 + stamp.nanosec + by, 1_000_000_000)
    return items


@pytest.mark.parametrize("topic", ["/scan", "/odom"])
def test_clocks_that_differ_give_way_to_the_times_of_logging(tmp_path, topic):
    items = bags.entries()
    for i, item in enumerate(one for one in items if one.topic == "/odom"):
        item.message.twist.twist.linear.x = 1.0 + 0.01 * i
    path = bags.write_rosbag2(tmp_path / "a", shifted(items, topic, -bags.START * 1_000_000_000 + 77))
    recording = load_recording(path)
    assert recording.speed == pytest.approx(1.0 + 0.01 * np.arange(60), abs=1e-6)
    assert np.all(recording.dts == bags.PERIOD)
    assert "the clocks of /scan and /odom are 1700000000.0 s apart: /odom is matched to the scans by log time" in (
        remarks(recording)
    )


def test_a_message_without_a_stamp_is_put_on_a_clock_that_began_at_power_on(tmp_path):
    kind = bags.ACKERMANN
    items = shifted(bags.entries(commands=False, odom=False), "/scan", -bags.START * 1_000_000_000)
    items += [
        bags.Entry("/cmd", kind, bags.nanoseconds(i), bags.make(kind, 0.001 * i, 0.0, 1.0, 0.0, 0.0)) for i in range(60)
    ]
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert recording.steering_angle == pytest.approx(0.001 * np.arange(60), abs=1e-6)


def test_a_scan_is_of_the_moment_of_its_last_ray(tmp_path):
    items = bags.entries()
    for i, item in enumerate(items):
        if item.topic == "/scan":
            item.message.time_increment = 0.02 / 270
        elif item.topic == "/odom":
            item.message.twist.twist.linear.x = 1.0 + i // 3
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert recording.start == pytest.approx(bags.START + 0.02, abs=1e-6)
    assert recording.speed[:-1] == pytest.approx(1.0 + np.arange(59) + 0.02 / bags.PERIOD, abs=1e-4)
    # A sweep cannot take longer than the scan period.
    for item in items:
        if item.topic == "/scan":
            item.message.time_increment = 0.1 / 270
    assert load_recording(bags.write_rosbag2(tmp_path / "b", items)).start == bags.START


def test_a_reindexed_bag_without_its_storages_name_is_read(tmp_path):
    for storage in ("sqlite3", "mcap"):
        path = bags.write_rosbag2(tmp_path / storage, bags.entries(), storage)
        about = path / "metadata.yaml"
        about.write_text(about.read_text().replace(f"storage_identifier: {storage}", "storage_identifier: ''"))
        assert len(load_recording(path)) == 60


def test_messages_that_are_compressed_are_read_without_metadata(tmp_path):
    path = bags.write_rosbag2(tmp_path / "a", bags.entries(), compression=CompressionMode.MESSAGE)
    (path / "metadata.yaml").unlink()
    assert len(load_recording(path)) == 60
    file = next(iter(path.iterdir()))
    assert len(load_recording(file.rename(tmp_path / "single.db3"))) == 60


def test_the_bag_of_a_recorder_that_was_killed_is_read(tmp_path):
    path = bags.write_bag(tmp_path / "a.bag", bags.entries(ros1=True)).rename(tmp_path / "a.bag.active")
    recording = load_recording(path)
    assert (len(recording), recording.name) == (60, "a")


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_a_single_compressed_file_is_read(tmp_path, kind):
    whole = bags.WRITERS[kind](tmp_path)
    for ending in ("zstd", "zst"):
        path = tmp_path / f"a.{kind}.{ending}"
        path.write_bytes(zstandard.ZstdCompressor().compress(whole.read_bytes()))
        recording = load_recording(path)
        assert (len(recording), recording.name) == (60, "a")
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(InputError, match="cannot be decompressed: truncated or damaged"):
        load_recording(path)
    path.write_bytes(b"hello")
    with pytest.raises(InputError, match="not compressed by zstd"):
        load_recording(path)


def test_types_that_nobody_knows_do_not_matter(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("float64[] secret\nstring word", "our_msgs/msg/Telemetry"))
    message = store.types["our_msgs/msg/Telemetry"](np.ones(3), "x")
    with Writer(tmp_path / "a", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        known = writer.add_connection("/scan", bags.SCAN, typestore=store)
        own = writer.add_connection("/telemetry", "our_msgs/msg/Telemetry", typestore=store)
        for entry in bags.entries(odom=False, commands=False):
            writer.write(own, entry.time, store.serialize_cdr(message, "our_msgs/msg/Telemetry"))
            writer.write(known, entry.time, store.serialize_cdr(entry.message, bags.SCAN))
    assert len(load_recording(tmp_path / "a")) == 60


def test_no_scan_inside_tells_what_is(tmp_path):
    path = bags.write_rosbag2(tmp_path / "a", [entry for entry in bags.entries() if entry.topic == "/odom"])
    with pytest.raises(InputError, match=r"contains no LaserScan, only nav_msgs/msg/Odometry"):
        load_recording(path)


def with_stamps(stamps: list[int], logged: list[int]) -> list[bags.Entry]:
    """Scans with stamps and log times in units of the scan period."""
    return [
        bags.Entry("/scan", bags.SCAN, bags.nanoseconds(log), bags.scan(bags.nanoseconds(stamp), bags.corridor(seed=i)))
        for i, (stamp, log) in enumerate(zip(stamps, logged, strict=True))
    ]


def test_stamps_that_jump_back_or_stand_still_give_way_to_the_times_of_logging(tmp_path):
    stamps = [*range(10), *range(5, 10), *[9] * 5]
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", with_stamps(stamps, list(range(20)))))
    assert len(recording) == 20
    assert np.all(recording.dts == bags.PERIOD)
    assert "6 of 20 stamps do not increase (5 repeated, 1 backward)" in remarks(recording)


def test_where_no_clock_advances_the_usual_period_is_taken(tmp_path):
    stamps = [*range(10), 3, *range(11, 20)]
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", with_stamps(stamps, [0] * 20)))
    assert len(recording) == 20
    assert np.all(np.diff(recording.stamps) > 0.0)
    assert "the median of 25.0 ms" in remarks(recording)


def test_a_pause_is_said(tmp_path):
    stamps = [*range(10), *range(100, 110)]
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", with_stamps(stamps, stamps)))
    assert "1 gap of more than 0.5 s, the longest 2.3 s" in remarks(recording)


def test_scans_that_change_size_are_read_by_their_own_header(tmp_path):
    items = bags.entries(40, odom=False, commands=False)
    for i in range(20, 40):
        items[i] = items[i]._replace(message=bags.scan(items[i].time, bags.corridor(541, seed=i)))
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert [len(one) for one in recording.ranges] == [271] * 20 + [541] * 20
    assert "the number of beams changes: 20 of 271 beams, 20 of 541 beams" in remarks(recording)


def test_scans_that_do_not_fit_their_own_header_are_left_out_and_counted(tmp_path):
    items = bags.entries(40, odom=False, commands=False)
    for i in range(10):
        message = bags.scan(items[i].time, bags.corridor(100), beams_by_header=271)
        items[i] = items[i]._replace(message=message)
    nothing = np.zeros(0, dtype=np.float32)
    items[10] = items[10]._replace(message=bags.scan(items[10].time, nothing, beams_by_header=271))
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert len(recording) == 29
    assert (
        "10 scans left out: 100 beams from -2.35619 rad by 0.0174533 rad do not end at angle_max 2.35619 rad"
        in remarks(recording)
    )
    assert "1 scans left out: 0 beams; at least 2 are needed" in remarks(recording)


def with_scans(change: Callable[[object, int], None], count: int = 40) -> list[bags.Entry]:
    """A corridor with modified scans, by change(message, index)."""
    items = bags.entries(count)
    for i, item in enumerate(item for item in items if item.topic == "/scan"):
        change(item.message, i)
    return items


def in_degrees(message: object, _: int) -> None:
    message.angle_min, message.angle_max, message.angle_increment = -135.0, 135.0, 1.0  # type: ignore[attr-defined]


def in_millimeters(message: object, _: int) -> None:
    message.ranges = 1000.0 * message.ranges  # type: ignore[attr-defined]
    message.range_max = 30000.0  # type: ignore[attr-defined]


def backward_time(message: object, _: int) -> None:
    message.time_increment = -1e-5  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (in_degrees, "are the angles in degrees?"),
        (in_millimeters, "are the ranges in millimeters or centimeters?"),
        (backward_time, "time_increment is -1e-05 s; it must be 0 or more"),
    ],
)
def test_scans_that_the_planner_would_refuse_are_refused_with_the_judges_reason(cli, tmp_path, change, words):
    path = bags.write_rosbag2(tmp_path / "a", with_scans(change))
    for command in (("replay", path), ("explain", path, "--scan", 0)):
        ran = cli(*command)
        assert ran.code == 2
        assert "no valid scan in /scan: " in ran.err
        assert words in ran.err


def test_single_scans_that_see_nothing_stay_and_are_said(tmp_path):
    def blind(message: object, index: int) -> None:
        if 10 <= index < 15:
            message.ranges = np.full(271, np.inf, dtype=np.float32)  # type: ignore[attr-defined]

    recording = load_recording(bags.write_rosbag2(tmp_path / "a", with_scans(blind)))
    assert len(recording) == 40
    assert "5 invalid scans: 0 of 271 beams return" in remarks(recording)


def test_a_sweep_that_lasts_longer_than_the_period_is_said_once(tmp_path):
    def long(message: object, _: int) -> None:
        message.time_increment = 1e-3  # type: ignore[attr-defined]

    recording = load_recording(bags.write_rosbag2(tmp_path / "a", with_scans(long)))
    assert remarks(recording).count("time_increment makes the sweep last 0.27 s") == 1
    assert "(in 40 of 40 scans)" in remarks(recording)


def test_a_laser_that_looks_back_is_refused_until_it_is_said_how_it_is_mounted(tmp_path):
    items = [bags.Entry("/tf_static", bags.TF, 0, bags.mounted(0.2, 0.0, np.pi))]
    path = bags.write_rosbag2(tmp_path / "b", [*items, *with_scans(narrow)])
    with pytest.raises(InputError, match=r"no beam points ahead.*--laser"):
        load_recording(path)
    assert len(load_recording(path, Topics(laser=parse_laser("0.2,0,0")))) == 40


def narrow(message: object, _: int) -> None:
    """A field of view of 60 degrees to either side."""
    message.angle_min, message.angle_max = -np.pi / 3, np.pi / 3  # type: ignore[attr-defined]
    message.angle_increment = 2.0 * np.pi / 3 / 270  # type: ignore[attr-defined]


def test_metadata_that_lies_about_counts_is_said(tmp_path):
    path = bags.write_rosbag2(tmp_path / "a", bags.entries())
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("message_count: 60", "message_count: 9000"))
    recording = load_recording(path)
    assert len(recording) == 60
    assert "/scan: 60 of 9000 messages in the metadata can be read" in remarks(recording)


def test_a_folder_without_good_metadata_is_read_file_by_file(tmp_path):
    odd = "rosbag2_bagfile_information: 3"
    for name, text in (("none", None), ("garbage", "{{{["), ("other", "a: 1"), ("odd", odd)):
        path = bags.write_rosbag2(tmp_path / name, bags.entries(), "mcap")
        about = path / "metadata.yaml"
        about.unlink()
        if text is not None:
            about.write_text(text)
        recording = load_recording(path)
        assert len(recording) == 60
        assert "metadata.yaml" in remarks(recording)


def test_a_missing_file_of_a_folder_is_said(tmp_path):
    path = bags.write_rosbag2(tmp_path / "a", bags.entries())
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("relative_file_paths:", "relative_file_paths:\n  - b.db3"))
    recording = load_recording(path)
    assert len(recording) == 60
    assert "metadata.yaml names b.db3, which does not exist" in remarks(recording)


@pytest.mark.parametrize(
    ("kind", "share"),
    [(kind, share) for kind in ("db3", "mcap", "bag") for share in (0.5, 0.9)] + [("packed as files", 0.9)],
)
def test_of_a_file_that_is_cut_off_the_rest_is_read(tmp_path, kind, share, chunk_size=6000):
    path = bags.WRITERS[kind](tmp_path)
    file = next(path.glob("*.zstd")) if path.is_dir() else path
    if kind == "mcap":
        path = file = unfinished_mcap(tmp_path / "u.mcap", chunk_size)
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    recording = load_recording(path)
    assert 0.3 * share * 60 < len(recording) < 60
    assert "cut off" in remarks(recording)


@pytest.mark.parametrize("packed", [False, True])
def test_a_chunk_that_is_cut_off_is_read_as_far_as_it_goes(tmp_path, packed):
    path = unfinished_mcap(tmp_path / "a.mcap", 10**6, packed, 500)
    data = path.read_bytes()
    path.write_bytes(data[: int(0.8 * len(data))])
    recording = load_recording(path)
    assert 200 < len(recording) < 500
    assert all(np.array_equal(one, bags.corridor(seed=i)) for i, one in enumerate(recording.ranges))
    assert "cut off" in remarks(recording)


def chunked_mcap(path: Path, packed: bool, count: int = 200) -> tuple[Path, list[tuple[int, int]]]:
    """A finished file of many chunks, and the offsets of each."""
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    from firstlap.recordings.messages import typestore

    with path.open("wb") as file:
        writer = Writer(file, 12_000, CompressionType.ZSTD if packed else CompressionType.NONE)
        writer.start("ros2")
        schema = writer.register_schema(bags.SCAN, "ros2msg", b"")
        channel = writer.register_channel("/scan", "cdr", schema)
        for entry in bags.entries(count, odom=False, commands=False):
            data = bytes(typestore().serialize_cdr(entry.message, bags.SCAN))
            writer.add_message(channel, entry.time, data, entry.time)
        writer.finish()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return path, [(one.chunk_start_offset, one.chunk_start_offset + one.chunk_length) for one in summary.chunk_indexes]


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_chunk_is_left_out_and_said_and_the_next_ones_are_read(tmp_path, packed, seed):
    dice = random.Random(seed)
    path, chunks = chunked_mcap(tmp_path / "a.mcap", packed)
    assert len(chunks) > 10
    data = bytearray(path.read_bytes())
    bad = {0, *dice.sample(range(1, len(chunks)), 2)}  # the first one explains the channels
    for index in bad:
        begin, end = chunks[index]
        # Seed 0 damages the record's length, which is then implausible.
        at = begin + 1 + dice.randrange(8) if seed == 0 else dice.randrange(begin + 60, end)
        data[at] ^= 1 + dice.randrange(255)
    path.write_bytes(data)
    recording = load_recording(path)
    assert 0.6 * 200 < len(recording) < (201 if seed == 0 else 200)
    whole = {bags.corridor(seed=i).tobytes() for i in range(200)}
    assert all(one.tobytes() in whole for one in recording.ranges)
    assert f"a.mcap is damaged: 3 parts were skipped, {len(recording)} messages were read" in remarks(recording)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_is_lost_to_damage_is_said(tmp_path, seed):
    dice = random.Random(seed)
    path, _ = chunked_mcap(tmp_path / "a.mcap", True)
    data = bytearray(path.read_bytes())
    for _ in range(dice.choice((1, 5, 20, 200))):
        data[dice.randrange(8, len(data))] = dice.randrange(256)
    path.write_bytes(data)
    try:
        recording = load_recording(path)
    except InputError as error:
        assert "damaged" in str(error)
    else:
        assert len(recording) == 200 or "damaged" in remarks(recording)


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_any_cut_is_said(tmp_path, kind):
    path = bags.WRITERS[kind](tmp_path)
    data = path.read_bytes()
    for seed in range(12):
        path.write_bytes(data[: random.Random(seed).randrange(20, len(data))])
        try:
            recording = load_recording(path)
        except InputError as error:
            assert "cut off" in str(error)
        else:
            assert "cut off" in remarks(recording)


def unfinished_mcap(path: Path, chunk_size: int, packed: bool = True, count: int = 60) -> Path:
    """A file of chunks without its end, as left by a killed writer."""
    from mcap.writer import CompressionType, Writer

    from firstlap.recordings.messages import typestore

    with path.open("wb") as file:
        writer = Writer(file, chunk_size, CompressionType.ZSTD if packed else CompressionType.NONE)
        writer.start("ros2")
        schema = writer.register_schema(bags.SCAN, "ros2msg", b"")
        channel = writer.register_channel("/scan", "cdr", schema)
        for entry in bags.entries(count, odom=False, commands=False):
            data = bytes(typestore().serialize_cdr(entry.message, bags.SCAN))
            writer.add_message(channel, entry.time, data, entry.time)
        writer.flush()
    return path


HOPELESS = {
    "empty.mcap": b"",
    "empty.db3": b"",
    "empty.bag": b"",
    "empty.npz": b"",
    "noise.mcap": random.Random(1).randbytes(4000),
    "noise.db3": random.Random(2).randbytes(4000),
    "noise.bag": random.Random(3).randbytes(4000),
    "noise.npz": random.Random(4).randbytes(4000),
    "head.mcap": b"\x89MCAP0\r\n" + random.Random(5).randbytes(400),
    "head.bag": b"#ROSBAG V2.0\n" + random.Random(6).randbytes(400),
    "head.db3": b"SQLite format 3\0" + random.Random(7).randbytes(4000),
    "what.txt": b"hello",
}


@pytest.mark.parametrize("name", HOPELESS)
def test_hopeless_files_are_refused_in_one_line(cli, tmp_path, name):
    (tmp_path / name).write_bytes(HOPELESS[name])
    ran = cli("replay", name)
    assert ran.code == 2
    assert ran.out == ""
    assert ran.err.startswith("error: ")
    assert ran.err.count("\n") == 1
    assert name in ran.err
    assert "Error" not in ran.err
    what = {"mcap": "an MCAP file", "db3": "an SQLite database", "npz": "an .npz recording", "bag": "a ROS 1 bag"}
    if name.startswith("noise"):
        assert f"not {what[name.rpartition('.')[2]]}" in ran.err


def test_a_numpy_file_that_is_cut_off_is_called_so(tmp_path):
    np.savez(tmp_path / "a.npz", ranges=np.ones((5, 271), dtype=np.float32), angle_min=-2.3, angle_increment=0.017)
    data = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match=r"a.npz: is cut off or damaged$"):
        load_recording(tmp_path / "a.npz")


def test_a_folder_around_another_kind_of_recording_names_it(tmp_path):
    (tmp_path / "lap.npz").write_bytes(b"")
    with pytest.raises(InputError, match=r"the folder contains no recording; give a file in it, such as lap\.npz$"):
        load_recording(tmp_path)


def test_remarks_whose_numbers_have_more_digits_are_of_one_kind():
    findings = Findings()
    for share in (9, 10, 9, 10):
        findings.keeps(Judgment(USABLE, "", (f"only {share} % of the beams return",)))
    assert findings.remarks() == ["only 9 % of the beams return (in 4 of 4 scans)"]


def test_folders_without_recording_are_refused(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="the folder contains no recording"):
        load_recording(tmp_path / "empty")
    path = bags.write_rosbag2(tmp_path / "a", bags.entries())
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("storage_identifier: sqlite3", "storage_identifier: tape"))
    with pytest.raises(InputError, match="unknown storage 'tape'; expected sqlite3, mcap"):
        load_recording(path)


@pytest.mark.parametrize("kind", ["db3", "mcap", "bag", "folder of sqlite3", "packed as messages"])
def test_any_damage_gives_a_recording_or_one_line(tmp_path, kind):
    whole = bags.WRITERS[kind](tmp_path)
    for seed in range(25):
        dice = random.Random(seed)
        path = tmp_path / f"damaged{whole.suffix}"
        shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(whole, path) if whole.is_dir() else shutil.copy(whole, path)
        file = dice.choice(sorted(path.iterdir())) if path.is_dir() else path
        data = bytearray(file.read_bytes())
        for _ in range(dice.choice((1, 5, 50))):
            data[dice.randrange(min(len(data), dice.choice((200, 5000, 10**9))))] = dice.randrange(256)
        file.write_bytes(data[: dice.randrange(1, len(data))] if dice.random() < 0.3 else data)
        try:
            recording = load_recording(path)
        except InputError as error:
            assert "\n" not in str(error)
        else:
            assert len(recording) == len(recording.states) == len(recording.dts)
            assert np.all(np.isfinite(recording.states))
            assert np.all(recording.dts > 0.0)


def test_numpy_files_say_what_is_wrong(tmp_path):
    good = {"ranges": np.ones((5, 271), dtype=np.float32), "angle_min": -2.3, "angle_increment": 0.017}
    for change, what in (
        ({"ranges": None}, "no LaserScan"),
        ({"angle_min": None}, "'angle_min'"),
        ({"angle_min": np.ones(3)}, "'angle_min' is not one finite number"),
        ({"ranges": np.ones((2, 3, 4))}, "'ranges' is float64"),
        ({"ranges": np.array(["a"])}, "'ranges' is <U1"),
        ({"stamps": np.arange(4)}, "'stamps' is int64 .4,., which does not fit 5 scans"),
        ({"pose_global": np.zeros((4, 3))}, "'pose_global'"),
        ({"speed": np.zeros((5, 2))}, "'speed'"),
    ):
        arrays = {key: value for key, value in {**good, **change}.items() if value is not None}
        np.savez(tmp_path / "a.npz", **arrays)
        with pytest.raises(InputError, match=what):
            load_recording(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", **good, stamps=[0.0, 0.1, 0.05, 0.05, 0.2], speed=np.full(5, 2.0))
    recording = load_recording(tmp_path / "a.npz")
    assert "stamps do not increase" in remarks(recording)
    assert np.all(recording.speed == 2.0)


@needs_scans
def test_a_real_rosbag_and_its_numpy_copy_are_one_recording():
    folder = SCANS / "sinside_corner_1_speed_1"
    topic = "/vesc/low_level/ackermann_cmd"
    bag = load_recording(folder / "rosbag2", Topics(drive=topic))
    copy = load_recording(folder / "sinside_corner_1_speed_1.npz")
    assert len(bag) == len(copy) == 605
    assert all(np.array_equal(a, b) for a, b in zip(bag.ranges, copy.ranges, strict=True))
    assert bag.stamps == pytest.approx(copy.stamps, abs=1e-6)
    assert bag.headers == pytest.approx(copy.headers, rel=1e-6)
    moving = bag.speed == 1.0
    assert np.mean(np.abs(bag.speed - copy.speed) < 0.05) > 0.95
    assert moving.sum() > 300


@needs_scans
def test_a_real_rosbag_with_several_commands_gives_those_that_reached_the_car():
    recording = load_recording(SCANS / "sinside_corner_1_speed_1" / "rosbag2")
    assert recording.topics["drive"] == "/vesc/low_level/ackermann_cmd"
    assert "of 3 AckermannDriveStamped topics, /vesc/low_level/ackermann_cmd is used" in remarks(recording)


@needs_scans
def test_the_real_bag_of_another_stack_plays_without_options():
    recording = load_recording(SCANS.parent / "more" / "scans" / "uos_lab_233131" / "2024-11-23-23-31-31.bag")
    assert recording.topics == {
        "scan": "/scan",
        "odom": "/car_state/odom",
        "imu": "/vesc/sensors/imu/raw",
        "drive": "/vesc/low_level/ackermann_cmd_mux/output",
        "pose": "/car_state/pose",
    }
    assert recording.frame == "map"
    assert recording.laser == pytest.approx((0.285, 0.0, 0.0, False))


@needs_scans
@pytest.mark.parametrize(("name", "scans", "laser_x"), [("germany2022", 797, 0.275), ("hangar12", 1900, 0.285)])
def test_real_recordings_with_poses_have_them_in_the_map(name, scans, laser_x):
    recording = load_recording(SCANS / name / f"{name}.npz")
    assert len(recording) == scans
    assert recording.frame == "map"
    assert recording.laser == (laser_x, 0.0, 0.0, False)
    assert recording.poses is not None
    assert recording.poses.shape == (scans, 3)
    # The speed from odometry is consistent with the poses in the map.
    way = float(np.sum(np.abs(recording.speed) * recording.dts * (recording.dts < 0.5)))
    steps = np.hypot(*np.diff(recording.poses[:, :2], axis=0).T)
    assert way == pytest.approx(float(np.sum(steps[recording.dts[1:] < 0.5])), rel=0.1)


@needs_scans
def test_a_real_recording_at_racing_speed_tells_its_state():
    recording = load_recording(SCANS / "rollcage" / "rollcage.npz")
    assert recording.speed.max() == pytest.approx(5.8, abs=0.1)
    assert recording.sources["steering_angle"] == "measured (steer)"
    assert recording.commands is not None
    assert np.all(np.isfinite(recording.commands.steering_angle))
