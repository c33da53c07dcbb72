"""The drivers of the C++ core."""

from __future__ import annotations

from typing import Any

from firstlap import _core
from firstlap.config.driver_kind import CoreHandle, DriverKind
from firstlap.config.parameters import FieldTable
from firstlap.config.setup_file import DEFAULT_SETUP, LOCAL


def _core_kind(name: str, title: str, params: Any, driver: Any, default_setup: str) -> DriverKind:
    return DriverKind(
        name=name,
        title=title,
        fields=FieldTable(params.fields()),
        new_params=params,
        make=lambda values, _car, _preparation: CoreHandle(driver(values)),
        default_setup=default_setup,
    )


CORE_DRIVERS = (
    _core_kind(LOCAL, "the method of the paper", _core.Params, _core.Racer, DEFAULT_SETUP),
    _core_kind("gap", "follow the gap", _core.FollowTheGapParams, _core.FollowTheGap, "gap"),
    _core_kind(
        "disparity", "the disparity extender", _core.DisparityExtenderParams, _core.DisparityExtender, "disparity"
    ),
    _core_kind("pid", "center following", _core.CenterPidParams, _core.CenterPid, "pid"),
)
