"""All rows of a field table as controls: grouped, searchable, marked if changed, and resettable."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from viser import Icon

from firstlap.common.errors import InputError
from firstlap.config.parameters import Field, FieldTable, Value
from firstlap.pitwall.controls import Change, Control, Current, shown
from firstlap.pitwall.viewer_session import ViewerSession, assign

LONGEST_SEARCH = 60
NOTHING_FOUND = '<div style="font-size:0.8em;padding:0 0.8em 0.5em">no parameter contains all these words</div>'


@dataclass
class _Group:
    label: str
    folder: Any
    controls: list[Control]


class ControlPanel:
    """Built in the current gui container.

    often: fields shown first, unfolded. loaded: the values of "reset". many: adds a search. changed_in: container of
    the list of changed values; the controls must not be below it, or they would move when the list grows.
    """

    def __init__(
        self,
        session: ViewerSession,
        table: FieldTable,
        often: Sequence[Field],
        current: Current,
        loaded: Current,
        change: Change,
        change_together: Callable[[dict[str, Value]], object],
        many: bool = True,
        changed_in: Any = None,
    ) -> None:
        self._session = session
        self._table = table
        self._current = current
        self._loaded = loaded
        self._change = change
        self._change_together = change_together
        self._resets: dict[str, Any] = {}
        gui = session.gui
        self._often = often
        self._parts: list[Any] = self._build_tools() if many else []
        self._groups = self._build(often)
        with changed_in if changed_in is not None else contextlib.nullcontext():
            self._changed = gui.add_folder("Changed", visible=False)
        with self._changed:
            gui.add_button("Reset all", icon=Icon.ARROW_BACK_UP).on_click(session.click("reset", self._reset_all))
        self._parts += [self._changed, *(group.folder for group in self._groups)]
        self.controls = [control for group in self._groups for control in group.controls]
        self.mark()

    def sync(self) -> bool:
        """Shows the current values; False if the viewer is using a control: then call it again."""
        done = [control.sync() for control in self.controls]
        self.mark()
        return all(done)

    def load(self) -> None:
        """Takes newly loaded values of the same table."""
        for control in self.controls:
            control.load(self._loaded(control.field.key))
        self.mark()

    def mark(self) -> None:
        """Marks changed values and offers to reset them."""
        changed = {control.field.key: control for control in self.controls if control.changed}
        for control in self.controls:
            control.mark()
        for key in [key for key in self._resets if key not in changed]:
            self._resets.pop(key).remove()
        with self._changed:
            for key, control in changed.items():
                self._offer_reset(key, control)
        assign(self._changed, "visible", bool(changed))

    def remove(self) -> None:
        """Removes all controls."""
        self._resets.clear()
        for handle in self._parts:
            handle.remove()

    def _offer_reset(self, key: str, control: Control) -> None:
        label = f"{control.field.name}: {shown(self._current(key))} → {shown(control.loaded)}"
        if key not in self._resets:
            button = self._session.gui.add_button(label, color="gray", icon=Icon.ARROW_BACK_UP)
            button.on_click(self._session.click(f"reset {control.field.name}", control.reset))
            self._resets[key] = button
        else:
            assign(self._resets[key], "label", label)

    def _build_tools(self) -> list[Any]:
        gui = self._session.gui
        search = gui.add_text("find", "", hint="words in names or descriptions")
        search.on_update(lambda event: self._find(event.target.value))
        hint = f"NAME=VALUE, also between the steps of a slider; for example {self._example()}"
        exact = gui.add_text("exactly", "", hint=hint)
        button = gui.add_button("Set exactly")
        button.on_click(self._session.click("set", lambda: self._set_exactly(exact.value)))
        self._nothing = gui.add_html(NOTHING_FOUND, visible=False)
        return [search, exact, button, self._nothing]

    def _build(self, often: Sequence[Field]) -> list[_Group]:
        first = list(often) if len(often) < len(self._table.fields) else []
        rest = [field for field in self._table.fields if field not in first]
        groups = [self._group("frequently changed", first, True)] if first else []
        sections = [section for section in self._table.sections if any(f.section == section for f in rest)]
        for section in sections:
            fields = [field for field in rest if field.section == section]
            groups.append(self._group(section, fields, len(sections) == 1))
        return groups

    def _group(self, label: str, fields: Sequence[Field], unfolded: bool) -> _Group:
        folder = self._session.gui.add_folder(label, expand_by_default=unfolded)
        with folder:
            controls = [Control(self._session, f, self._loaded(f.key), self._current, self._change) for f in fields]
        return _Group(label, folder, controls)

    def _find(self, text: str) -> None:
        with self._session.lock, self._session.client.atomic():
            text = text[:LONGEST_SEARCH].strip()
            for group in self._groups:
                hits = [control for control in group.controls if control.matches(text)]
                for control in group.controls:
                    control.show(control in hits)
                group.folder.visible = bool(hits)
                # A folder without a label cannot be collapsed, so the matches are visible.
                group.folder.label = None if text else group.label
            self._nothing.visible = not any(group.folder.visible for group in self._groups)

    def _set_exactly(self, text: str) -> None:
        if "=" not in text:
            raise InputError(f"'{text[:LONGEST_SEARCH]}': expected NAME=VALUE, for example {self._example()}")
        field, value = self._table.parse_assignment(text, "exactly", self._example())
        self._change(field.key, value)
        self._session.notify(f"{field.name} = {shown(value)}", field.doc)

    def _reset_all(self) -> None:
        self._change_together({control.field.key: control.loaded for control in self.controls if control.changed})

    def _example(self) -> str:
        fields = [*self._often, *self._table.fields]
        field = next((field for field in fields if field.type == "float"), fields[0])
        return f"{field.key}={shown(self._loaded(field.key))}"
