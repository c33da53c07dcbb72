"""The pit wall's controls, operated over a real WebSocket like the page does."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

import viser
from standing import Standing, StandingCar, StandingTape
from viewing import Viewer, served, wait_until

from firstlap.common.errors import InputError
from firstlap.config.parameters import Field
from firstlap.config.setup_file import load_setup
from firstlap.pitwall import controls
from firstlap.pitwall.authentication import Authenticator
from firstlap.pitwall.camera import ground_point
from firstlap.pitwall.drive_panel import heading_along
from firstlap.pitwall.limits_panel import rules_html
from firstlap.pitwall.panel import Panel, WatchPanel
from firstlap.pitwall.saving import save_setup
from firstlap.plots.colors import BAD

pytestmark = pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")


class Wall:
    """A server with one source; every viewer has a panel that is updated as by the app."""

    def __init__(self, authenticator: Authenticator, server: viser.ViserServer, folder: Path) -> None:
        self.authenticator = authenticator
        self.server = server
        self.folder = folder
        self.source: Standing = StandingCar()
        self.panels: dict[int, Panel | WatchPanel] = {}
        self.made = threading.Event()
        self.done = threading.Event()
        server.on_client_connect(self._enter)
        server.on_client_disconnect(self._leave)
        self.loop = threading.Thread(target=self._run)
        self.loop.start()

    def _enter(self, client: viser.ClientHandle) -> None:
        control = self.authenticator.may_control(client)
        self.panels[client.client_id] = (
            Panel(client, self.source, self.folder) if control else WatchPanel(client, self.source)
        )
        self.made.set()

    def _leave(self, client: viser.ClientHandle) -> None:
        self.panels.pop(client.client_id).close()

    def _run(self) -> None:
        while not self.done.wait(0.02):
            for panel in tuple(self.panels.values()):
                panel.update(self.source.latest())

    @contextlib.contextmanager
    def viewer(self) -> Iterator[Page]:
        """Connects a viewer with a page."""
        self.made.clear()
        before = len(self.panels)
        viewer = Viewer(self.authenticator).enter()
        assert self.made.wait(5)
        page = Page(viewer)
        page.until(lambda: "rules" in page.text())
        yield page
        viewer.close()
        wait_until(lambda: len(self.panels) == before)


class Page:
    """The state of a page: the newest properties of every element."""

    def __init__(self, viewer: Viewer) -> None:
        self.viewer = viewer
        self.elements: dict[str, dict[str, Any]] = {}
        self.commands: dict[str, dict[str, Any]] = {}
        self.notices: list[dict[str, Any]] = []
        self.updates = 0

    def look(self, seconds: float = 0.0) -> Page:
        """Processes received messages."""
        for message in self.viewer.heard(seconds or 0.06):
            kind = message["type"]
            if kind == "GuiUpdateMessage":
                self.updates += 1
                self.elements.get(message["uuid"], {}).update(message["updates"])
            elif kind == "GuiRemoveMessage":
                self.elements.pop(message["uuid"], None)
            elif kind == "NotificationShowMessage":
                self.notices.append(message["props"])
            elif kind == "RegisterCommandMessage":
                self.commands[message["uuid"]] = message["props"]
            elif kind.startswith("Gui") and "props" in message:
                values = {"value": message["value"]} if "value" in message else {}
                self.elements[message["uuid"]] = {"kind": kind, **message["props"], **values}
        return self

    def until(self, condition: Any, seconds: float = 4.0) -> None:
        """Waits for a condition."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "never shown"
            self.look()

    def find(self, label: str) -> str | None:
        """The element whose label starts with this text, marked as changed or not."""
        labels = {uuid: (element.get("label") or "") for uuid, element in self.elements.items()}
        return next((uuid for uuid, text in labels.items() if text.removeprefix(controls.MARK).startswith(label)), None)

    def uuid(self, label: str) -> str:
        """The uuid of an existing element."""
        found = self.find(label)
        assert found is not None, f"no {label}"
        return found

    def see(self, label: str) -> dict[str, Any]:
        """The properties of an element."""
        return self.elements[self.uuid(label)]

    def value(self, label: str) -> object:
        """The value of an element; None without it."""
        found = self.find(label)
        return None if found is None else self.elements[found]["value"]

    def move(self, label: str, *values: Any) -> None:
        """Changes the value of an element."""
        for value in values:
            self.see(label)["value"] = value
            self.viewer.update(self.uuid(label), value)

    def press(self, label: str) -> None:
        """Clicks a button."""
        self.viewer.update(self.uuid(label), True)

    def text(self) -> str:
        """All HTML of the page."""
        return " ".join(str(e["content"]) for e in self.elements.values() if "content" in e)


@pytest.fixture(scope="module")
def whole_wall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Wall]:
    """The server, started once."""
    authenticator = Authenticator()
    with served(authenticator) as server:
        wall = Wall(authenticator, server, tmp_path_factory.mktemp("setups"))
        yield wall
        wall.done.set()
        wall.loop.join()


@pytest.fixture(scope="module")
def whole_page(whole_wall: Wall) -> Iterator[Page]:
    """The page of a permanent viewer."""
    with whole_wall.viewer() as page:
        yield page


@pytest.fixture
def wall(whole_wall: Wall, monkeypatch: pytest.MonkeyPatch) -> Wall:
    """With the loaded setup, and shorter delays."""
    monkeypatch.setattr(controls, "SETTLING_TIME", 0.2)
    monkeypatch.setattr(controls, "HOLD", 0.1)
    whole_wall.source.anew()
    return whole_wall


@pytest.fixture
def page(wall: Wall, whole_page: Page) -> Page:
    """A page with the loaded values."""
    setup = wall.source.setup
    labels = {f"{field.name} {field.unit}".strip(): setup.get(field.key) for field in setup.fields.fields}
    whole_page.until(lambda: all(whole_page.value(label) == value for label, value in labels.items()))
    whole_page.notices.clear()
    return whole_page


def test_every_parameter_has_a_control_with_its_name_unit_range_and_doc(wall: Wall, page: Page) -> None:
    for field in wall.source.setup.fields.fields:
        shown = page.see(f"{field.name} {field.unit}".strip())
        assert shown["value"] == wall.source.setup.get(field.key)
        assert field.doc in shown["hint"]
        assert field.range in shown["hint"]
        if "min" in shown and shown["min"] is not None:
            assert (shown["min"], shown["max"]) == (field.min, field.max)


@pytest.mark.parametrize("low,high", [(0.0, 1.0), (0.1, 20.0), (-20.0, -0.1), (0.02, 0.5), (0.0, 0.1), (1.0, 400.0)])
def test_steps_are_round_and_about_a_200th(low: float, high: float) -> None:
    step = controls.step_of(Field("s", "n", "", low, high, low, "", "float"))
    assert 80 <= (high - low) / step <= 200
    assert f"{step:e}"[0] in "125"
    assert float(f"{step:e}".partition("e")[0]) in (1.0, 2.0, 5.0)


def test_a_slider_changes_what_drives(wall: Wall, page: Page) -> None:
    page.move("k_ang", 0.61, 0.62)
    wait_until(lambda: wall.source.setup.get("k_ang") == 0.62)


def test_a_box_takes_values_between_the_steps(wall: Wall, page: Page) -> None:
    assert page.see("k_ang")["precision"] == controls.DIGITS
    page.move("k_ang", 0.61234)
    wait_until(lambda: wall.source.setup.get("k_ang") == 0.61234)


def test_what_is_typed_on_the_way_to_a_number_never_drives(
    wall: Wall, page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(controls, "SETTLING_TIME", 1.0)
    page.move("k_ang", 0, 0.3, 0.35)
    wait_until(lambda: wall.source.setup.get("k_ang") == 0.35)
    assert {"stanley.k_ang": 0.0} not in wall.source.changes


@pytest.mark.parametrize(("label", "value"), [("k_ang", 7.0), ("kappa_n", 1e9), ("k_ang", float("nan"))])
def test_a_value_out_of_range_is_refused_visibly(wall: Wall, page: Page, label: str, value: float) -> None:
    before = wall.source.setup
    page.move(label, value)
    page.until(lambda: page.notices)
    assert page.notices[0]["color"] == "red"
    assert "allowed: " in page.notices[0]["body"] or "not a number" in page.notices[0]["body"]
    page.until(lambda: page.see(label)["value"] == before.get(label))
    assert wall.source.setup is before


def test_leaving_the_box_of_an_impossible_value_does_not_make_it_the_nearest(
    wall: Wall, page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = wall.source.setup
    monkeypatch.setattr(controls, "SETTLING_TIME", 1.0)
    page.move("v_max", 99.0, 20.0)
    page.until(lambda: page.notices)
    assert "99" in page.notices[0]["body"]
    assert wall.source.setup is before


def test_a_pair_that_contradicts_itself_is_refused_visibly(wall: Wall, page: Page) -> None:
    page.move("v_min", 9.0)
    page.until(lambda: page.notices)
    assert "v_min" in page.notices[0]["body"]
    page.until(lambda: page.see("v_min")["value"] == wall.source.setup.get("v_min"))
    assert wall.source.changes == []


def test_what_was_changed_is_marked_and_put_back_one_by_one_or_together(wall: Wall, page: Page) -> None:
    page.move("k_ang", 0.65)
    page.move("deskew", False)
    page.until(lambda: page.see("k_ang")["label"].startswith(controls.MARK))
    page.until(lambda: page.see("deskew")["label"].startswith(controls.MARK))
    page.press("k_ang: 0.65")
    page.until(lambda: not page.see("k_ang")["label"].startswith(controls.MARK))
    assert wall.source.setup.get("k_ang") == wall.source.loaded.get("k_ang")
    assert wall.source.setup.get("deskew") is False
    page.press("Reset all")
    page.until(lambda: page.see("deskew")["value"] is True)
    assert wall.source.setup.values() == wall.source.loaded.values()


def test_values_can_be_set_exactly(wall: Wall, page: Page) -> None:
    page.move("exactly", "stanley.k_ang=0.123456789")
    page.press("Set exactly")
    wait_until(lambda: wall.source.setup.get("k_ang") == 0.123456789)
    page.move("exactly", "k_angg=1")
    page.press("Set exactly")
    page.until(lambda: any("k_angg" in notice["body"] for notice in page.notices))


def test_a_search_shows_what_matches_unfolded_and_nothing_else(page: Page) -> None:
    page.move("find", "yaw-rate")
    page.until(lambda: page.see("k_ang")["visible"] is False)
    assert page.see("k_rate")["visible"]
    page.move("find", "no such words")
    page.until(lambda: nothing_found(page))
    page.move("find", "")
    page.until(lambda: not nothing_found(page))
    page.until(lambda: page.see("k_ang")["visible"])
    assert page.see("segmentation")["visible"]


def nothing_found(page: Page) -> bool:
    return any("no parameter" in str(e.get("content")) and e["visible"] for e in page.elements.values())


def test_two_who_control_see_each_other_and_do_not_quarrel(wall: Wall, page: Page) -> None:
    with wall.viewer() as second:
        page.move("k_ang", 0.61, 0.62, 0.63)
        second.until(lambda: second.see("k_ang")["value"] == 0.63)
        page.look(0.3)
        second.look(0.1)
        mine, others = page.updates, second.updates
        page.look(0.2)
        second.look(0.2)
        assert (page.updates, second.updates) == (mine, others)
    assert page.see("k_ang")["value"] == 0.63
    assert wall.source.changes[-1] == {"stanley.k_ang": 0.63}


def test_a_hand_on_a_slider_is_not_pushed(wall: Wall, page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(controls, "HOLD", 0.5)
    page.move("k_dist", 0.55)
    wait_until(lambda: wall.source.changes)
    wall.source.change({"k_dist": 2.0})
    page.look(0.2)
    shown = page.see("k_dist")["value"]
    assert shown != 2.0
    wait_until(lambda: wall.source.setup.get("k_dist") == 2.0)
    page.until(lambda: page.see("k_dist")["value"] == wall.source.setup.get("k_dist"))


def test_the_rules_are_recomputed_and_red_where_broken(wall: Wall, page: Page) -> None:
    page.until(lambda: "rules" in page.text())
    wall.source.change({"a_y_max": 20.0})
    page.until(lambda: "✗ grip in corners" in page.text())
    assert BAD in page.text()
    wall.source.change({"a_y_max": 2.0})
    page.until(lambda: "✓ grip in corners" in page.text())


def test_names_in_the_rules_are_text() -> None:
    from firstlap.evaluation.setup_limits import LimitCheck

    assert "<script>" not in rules_html([LimitCheck("<script>", "<script>", 1.0, "<script>", "", False, "<script>")])


def test_the_emergency_stop_is_a_button_and_two_keys(wall: Wall, page: Page) -> None:
    assert isinstance(wall.source, StandingCar)
    assert page.see("EMERGENCY STOP")["color"] == "red"
    page.press("EMERGENCY STOP")
    wait_until(lambda: wall.source.orders == ["stop"])
    keys = {props["hotkey"]: uuid for uuid, props in page.commands.items() if props["label"] == "Emergency stop"}
    assert set(keys) == {"space", "escape"}
    page.viewer.say(type="CommandTriggerMessage", uuid=keys["space"])
    wait_until(lambda: wall.source.orders == ["stop", "stop"])
    page.until(lambda: "STOPPED" in page.text())


def test_the_key_that_stops_does_not_press_go_as_well(wall: Wall, page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    assert isinstance(wall.source, StandingCar)
    page.press("EMERGENCY STOP")
    page.press("Go")
    page.look(0.2)
    assert wall.source.orders == ["stop"]
    monkeypatch.setattr("firstlap.pitwall.drive_panel.GO_LOCKOUT", 0.0)
    page.press("Go")
    wait_until(lambda: wall.source.orders == ["stop", "go"])


def test_restart_and_placing_by_hand(wall: Wall, page: Page) -> None:
    assert isinstance(wall.source, StandingCar)
    page.press("Restart")
    wait_until(lambda: wall.source.orders == ["restart"])
    click = {
        "type": "ScenePointerMessage",
        "event_type": "click",
        "ray_origin": [9.0, 4.0, 8.0],
        "ray_direction": [0.0, 0.0, -1.0],
        "screen_pos": [[0.5, 0.5]],
        "modifier": None,
    }
    page.viewer.say(**click)
    page.look(0.1)
    assert wall.source.orders == ["restart"]
    page.press("Place the car")
    page.until(lambda: page.find("Click on the ground"))
    page.viewer.say(**click)
    wait_until(lambda: len(wall.source.orders) == 2)
    x, y, yaw = wall.source.orders[1]  # type: ignore[misc]
    assert (x, y) == (9.0, 4.0)
    assert yaw == pytest.approx(1.5708, abs=1e-4)
    page.until(lambda: page.see("heading")["visible"])
    page.move("heading", 10.0)
    wait_until(lambda: len(wall.source.orders) == 3)


def test_a_ray_that_misses_the_ground_places_nothing() -> None:
    assert ground_point((0.0, 0.0, 5.0), (0.0, 0.0, 1.0)) is None
    assert ground_point((0.0, 0.0, 5.0), (1.0, 0.0, 0.0)) is None
    assert ground_point((0.0, 0.0, 5.0), (3.0, 0.0, -1.0)) == (15.0, 0.0)
    assert heading_along(Standing.scenery.centerline[:0], (0.0, 0.0), 0.7) == 0.7


def test_the_conditions_of_the_simulated_car_have_controls(wall: Wall, page: Page) -> None:
    assert isinstance(wall.source, StandingCar)
    field = wall.source.conditions.fields[0]
    page.move(field.name, field.default + 2.0 * controls.step_of(field))
    wait_until(lambda: wall.source.condition(field.key) != field.default)
    page.move(field.name, field.max * 10.0)
    page.until(lambda: page.notices)


def test_another_driver_brings_its_own_controls(wall: Wall, page: Page) -> None:
    page.move("driver", "gap")
    wait_until(lambda: wall.source.setup.driver == "gap")
    page.until(lambda: page.find("k_ang") is None)
    assert set(page.see("setup")["options"]) >= {"gap", "gap_arena"}
    page.move("setup", "gap_arena")
    wait_until(lambda: wall.source.loaded.name == "gap_arena")


def test_a_driver_that_cannot_drive_is_refused_and_the_choice_goes_back(wall: Wall, page: Page) -> None:
    page.move("driver", "global")
    page.until(lambda: page.notices, 10.0)
    assert "map" in page.notices[0]["body"] or "global" in page.notices[0]["body"]
    page.until(lambda: page.see("driver")["value"] == "local")


def test_a_mistake_of_ours_is_said_and_printed(
    wall: Wall, page: Page, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(wall.source, "restart", lambda: 1 / 0)
    monkeypatch.setattr(wall.source, "change", lambda values: 1 / 0)
    page.move("k_ang", 0.61)
    page.until(lambda: page.notices)
    assert "ZeroDivisionError" in page.notices[0]["body"]
    assert capfd.readouterr().err.startswith("view: k_ang: ZeroDivisionError")


def test_saving_writes_a_setup_that_loads_and_says_how_to_race_it(wall: Wall, page: Page) -> None:
    page.move("k_ang", 0.62)
    wait_until(lambda: wall.source.setup.get("k_ang") == 0.62)
    page.move("name", "mine")
    page.press("Save setup")
    page.until(lambda: page.notices)
    assert "firstlap race TRACK --setup mine.yaml" in page.notices[0]["body"]
    saved = load_setup(wall.folder / "mine.yaml")
    assert saved.values() == wall.source.setup.values()
    assert "k_ang" in (wall.folder / "mine.yaml").read_text().split("\n")[1]
    page.press("Save setup")
    page.until(lambda: len(page.notices) == 2)
    assert "replace" in page.notices[1]["body"]


@pytest.mark.parametrize("name", ["../x", "/tmp/x", "a/b", "..", "", ".hidden", "race", "a\nb", "x" * 99, "nul\0"])
def test_a_name_that_leads_elsewhere_or_is_ours_is_refused(tmp_path: Path, name: str) -> None:
    setup = load_setup("base")
    folder = tmp_path / "in"
    folder.mkdir()
    with pytest.raises(InputError, match="save: "):
        save_setup(setup, setup, folder, name, "oval", True)
    assert list(tmp_path.rglob("*.yaml")) == []


def test_a_link_that_leads_elsewhere_is_replaced_not_followed(tmp_path: Path) -> None:
    setup = load_setup("base")
    (tmp_path / "in").mkdir()
    other = tmp_path / "other.yaml"
    other.write_text("kept")
    (tmp_path / "in" / "mine.yaml").symlink_to(other)
    save_setup(setup, setup, tmp_path / "in", "mine", "oval", True)
    assert other.read_text() == "kept"


def test_a_watcher_has_nothing_to_turn(wall: Wall, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wall.authenticator, "may_control", lambda client: False)
    with wall.viewer() as page:
        page.until(lambda: "rules" in page.text())
        assert {element["kind"] for element in page.elements.values()} == {"GuiHtmlMessage"}
        assert page.commands == {}


def test_a_recording_is_played_stepped_and_wound(wall: Wall, monkeypatch: pytest.MonkeyPatch) -> None:
    tape = StandingTape()
    monkeypatch.setattr(wall, "source", tape)
    with wall.viewer() as page:
        page.press("Play")
        page.until(lambda: tape.playing and page.find("Pause"))
        page.move("step", "+10")
        wait_until(lambda: tape.scan == 10)
        assert not tape.playing
        page.until(lambda: page.see("scan")["value"] == 10)
        page.move("scan", 400)
        wait_until(lambda: tape.scan == 400)
        page.until(lambda: "scan 400 of 500" in page.text())
        page.move("playback speed", "5")
        wait_until(lambda: tape.pace == 5.0)
        keys = {props["hotkey"]: uuid for uuid, props in page.commands.items()}
        page.viewer.say(type="CommandTriggerMessage", uuid=keys["arrowleft"])
        wait_until(lambda: tape.scan == 399)
