"""firstlap view"""

from __future__ import annotations

import errno
import os
import socket
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from firstlap.cli.common import (
    DriverOption,
    LidarOption,
    SetOption,
    SetupOption,
    chosen_car,
    chosen_setup,
    note,
    refuse,
)
from firstlap.cli.recording import (
    DriveTopic,
    ImuTopic,
    KeepBody,
    LaserOption,
    OdomTopic,
    PoseTopic,
    ScanTopic,
    SpeedOption,
    given_options,
    read,
    setup_and_car,
    topics_of,
)
from firstlap.cli.ros_arguments import ros_arguments
from firstlap.common.errors import InputError, missing_extra
from firstlap.common.yaml_text import read_text
from firstlap.pitwall.conditions import PACE_FIELDS, checked_pace
from firstlap.recordings.paths import KINDS, is_recording
from firstlap.tracks.library import TRACK_FILES, list_tracks, load_track

if TYPE_CHECKING:
    from firstlap.config.car_file import Car
    from firstlap.pitwall.app import MakePanel
    from firstlap.pitwall.source import Source

PORT = 8080
PORTS_TRIED = 20
"""Number of ports to try from the default one, if none was given."""
TOKEN_VARIABLE = "FIRSTLAP_TOKEN"
"""The environment variable with the control token."""
PACES = PACE_FIELDS.fields[0].range

WhatArgument = Annotated[
    str | None,
    typer.Argument(metavar="TRACK|RECORDING", help="A track as for `race`, or a recording as for `replay`."),
]
RosOption = Annotated[bool, typer.Option("--ros", help="Show a car or simulator over ROS 2.")]
NamespaceOption = Annotated[
    str | None,
    typer.Option("--namespace", metavar="NAME", help="With --ros: namespace of the car, if there are several."),
]
CarOption = Annotated[
    str | None,
    typer.Option("--car", metavar="CAR", help="default, nuc2, gym or a YAML file; default: the log's car."),
]
SeedOption = Annotated[int | None, typer.Option("--seed", min=0, help="For a race: seed of all randomness.")]
ReverseOption = Annotated[bool, typer.Option("--reverse", help="For a race: drive in the opposite direction.")]
PaceOption = Annotated[
    float | None,
    typer.Option("--pace", metavar="TIMES", help=f"Playback speed, as a multiple of real time: {PACES}."),
]
MapPathOption = Annotated[
    Path | None, typer.Option("--map", metavar="MAP", help="For a recording with poses: their map.")
]
HostOption = Annotated[
    str, typer.Option("--host", metavar="ADDRESS", help="Address to listen on; other machines need a token.")
]
PortOption = Annotated[
    int | None,
    typer.Option("--port", min=0, max=65535, help=f"Port to listen on; default: {PORT}, or the next free one; 0: any."),
]
TokenFileOption = Annotated[
    Path | None,
    typer.Option("--token-file", metavar="FILE", help="File whose first line is the control token; -: standard input."),
]
OpenBrowserOption = Annotated[bool, typer.Option("--open/--no-open", help="Open the browser.")]


def view(
    context: typer.Context,
    what: WhatArgument = None,
    ros: RosOption = False,
    namespace: NamespaceOption = None,
    driver: DriverOption = None,
    setup: SetupOption = None,
    changes: SetOption = None,
    car: CarOption = None,
    lidar: LidarOption = None,
    seed: SeedOption = None,
    reverse: ReverseOption = False,
    pace: PaceOption = None,
    map_path: MapPathOption = None,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    imu_topic: ImuTopic = None,
    drive_topic: DriveTopic = None,
    pose_topic: PoseTopic = None,
    speed: SpeedOption = None,
    laser: LaserOption = None,
    keep_body: KeepBody = False,
    host: HostOption = "127.0.0.1",
    port: PortOption = None,
    token_file: TokenFileOption = None,
    open_browser: OpenBrowserOption = True,
) -> int:
    """Watch a driver and change its parameters live in the browser. Arguments after --ros-args go to ROS."""
    try:
        import viser  # noqa: F401
    except ImportError:
        raise missing_extra("firstlap view", "viser", "view") from None

    topics = topics_of(scan_topic, odom_topic, imu_topic, drive_topic, pose_topic, speed, laser)
    race_options = {"--seed": seed, "--reverse": reverse or None, "--lidar": lidar}
    recording_options = {**given_options(topics, keep_body), "--map": map_path}
    shared_options = {"--driver": driver, "--setup": setup, "--set": changes, "--car": car, "--pace": pace}
    times = 1.0 if pace is None else checked_pace(pace)
    if ros:
        refuse({"the argument": what, **shared_options, **race_options, **recording_options}, "with --ros")
        source = _ros(ros_arguments(context, namespace or ""))
    elif namespace is not None:
        raise InputError("--namespace: has no effect without --ros")
    elif what is None:
        raise InputError("expected a track, a recording, or --ros; for example `firstlap view arena`")
    elif is_track(what):
        refuse(recording_options, "with a track")
        chosen = chosen_setup(setup, changes, driver)
        source = _race(
            what,
            chosen,
            chosen_car("default" if car is None else car, lidar),
            1 if seed is None else seed,
            reverse,
            times,
        )
    else:
        refuse(race_options, "with a recording")
        loaded = read(Path(what), topics)
        chosen, loaded_car, remarks = setup_and_car(loaded, driver, setup, changes, car)
        _note_all(loaded, loaded_car, remarks)
        source = _recording(loaded, chosen, loaded_car, map_path, not keep_body, times)
    return _serve(source, host, choose_port(host, port), _token(token_file), open_browser)


def is_track(what: str) -> bool:
    """Whether the argument names a track rather than a recording. Raises InputError if it is neither."""
    if what in list_tracks() or what.startswith("random:"):
        return True
    path = Path(what)
    if not path.exists():
        if is_recording(path):
            raise InputError(f"{what}: no such recording")
        try:
            load_track(what)
        except InputError as error:
            raise InputError(f"{error}; a recording is {KINDS}") from None
    return path.suffix.lower() in TRACK_FILES


def _token(file: Path | None) -> str | None:
    """The control token, from a file, standard input or the environment; not from the command line, which all users
    of the machine can read. Raises InputError."""
    if file is None:
        return os.environ.get(TOKEN_VARIABLE)
    text = sys.stdin.readline() if str(file) == "-" else read_text(file, "a file with a token")
    return (text.splitlines() or [""])[0].strip()


def _race(track: str, setup: Any, car: Car, seed: int, reverse: bool, pace: float) -> Source:
    from firstlap.pitwall.sim_source import SimSource

    loaded = load_track(track)
    for remark in loaded.notes:
        note(remark)
    return SimSource(loaded.reversed() if reverse else loaded, setup, car, seed=seed, pace=pace)


def _recording(recording: Any, setup: Any, car: Any, map_path: Path | None, mask_body: bool, pace: float) -> Source:
    from firstlap.pitwall.recording_source import RecordingSource, track_under

    track = None if map_path is None else track_under(recording, map_path)
    return RecordingSource(recording, setup, car, track=track, mask_body=mask_body, pace=pace)


def _note_all(recording: Any, car: Car, remarks: list[str]) -> None:
    from firstlap.mapping.contradictions import contradictions

    for remark in (*recording.remarks, *remarks, *contradictions(recording, car)):
        note(remark)


def _ros(arguments: list[str]) -> Source:
    from firstlap.ros import require_ros

    require_ros()
    from firstlap.pitwall.ros_source import RosSource

    source: Source = RosSource(arguments)
    return source


def choose_port(host: str, port: int | None) -> int:
    """The port that was given, or the first free one from the default port on. Raises InputError."""
    if port is not None:
        return port
    for candidate in range(PORT, PORT + PORTS_TRIED):
        if _is_free(host, candidate):
            if candidate != PORT:
                note(f"port {PORT} is in use: using {candidate}")
            return candidate
    raise InputError(
        f"ports {PORT} to {PORT + PORTS_TRIED - 1} are in use; choose another with --port, or --port 0 for any"
    )


def _is_free(host: str, port: int) -> bool:
    """Whether the port is free; also true if that cannot be determined: the server then reports the error."""
    try:
        with socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET):
            return True
    except OSError as error:
        return error.errno != errno.EADDRINUSE


def _serve(source: Source, host: str, port: int, token: str | None, open_browser: bool) -> int:
    from firstlap.pitwall.app import serve
    from firstlap.pitwall.authentication import Authenticator

    authenticator, app = Authenticator(token), None
    try:
        source.start()
        app = serve(source, host=host, port=port, authenticator=authenticator, panel=panels_of(source))
        _print_address(authenticator)
        if open_browser and _has_display():
            _open(authenticator.opening_url())
        _wait()
    finally:
        if app is not None:
            app.close()
        source.close()
    return 0


def panels_of(source: Source) -> MakePanel:
    """The control panel for clients that may control, and a read-only one for all others."""
    from firstlap.pitwall.panel import Panel, WatchPanel

    def panel(client: Any, may_control: bool, on_map: Any) -> Any:
        return Panel(client, source, on_map=on_map) if may_control else WatchPanel(client, source)

    return panel


def _print_address(authenticator: Any) -> None:
    if authenticator.warning:
        print(f"warning: {authenticator.warning}", file=sys.stderr)
    print(authenticator.url, flush=True)
    if authenticator.watch_url:
        print(f"read-only: {authenticator.watch_url}", flush=True)
    note("Ctrl-C to stop")


def _wait() -> None:
    """Waits for Ctrl-C."""
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        return


def _has_display() -> bool:
    """Whether there is a display for a browser; a text-mode browser would take over the terminal."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _open(address: str) -> None:
    import webbrowser

    threading.Thread(target=webbrowser.open, args=(address,), kwargs={"new": 2}, daemon=True).start()
