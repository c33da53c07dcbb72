"""The result of a tuning as one JSON object."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from firstlap.common.version import __version__
from firstlap.config.setup_file import Setup
from firstlap.evaluation.setup_limits import check_limits
from firstlap.tuning.candidate import Verdict
from firstlap.tuning.run import Tuned
from firstlap.tuning.selection import Chosen
from firstlap.tuning.validate import Validation


def summary(tuned: Tuned, files: Mapping[str, Path], study_file: Path, validation: Validation | None) -> dict[str, Any]:
    """As in `firstlap tune --json`."""
    session, search = tuned.session, tuned.search
    return {
        "version": __version__,
        "track": session.spec,
        "direction": "reverse" if session.reverse else "forward",
        "driver": session.driver,
        "car": session.car.name,
        "seed": session.seed,
        "seeds": session.seeds,
        "judge": session.judge,
        "study": tuned.study.name,
        "study_file": str(study_file),
        "trials": len(tuned.study.trials),
        "laps": round(tuned.study.laps, 1),
        "seconds": round(tuned.study.seconds, 3),
        "laps_per_second": round(tuned.study.laps / max(tuned.study.seconds, 1e-9), 2),
        "workers": tuned.workers,
        "cpu_seconds": round(search.cpu_seconds, 1),
        "compared_with": {"setup": search.compared.name, "lap": tuned.reference, **_safety(tuned.choice.compared)},
        **{
            role: describe(tuned, chosen, files[role]) if chosen else None
            for role, chosen in (("holds", tuned.choice.holds), ("seen", tuned.choice.seen))
        },
        "validation": validation.to_dict() if validation else None,
    }


def _safety(check: Verdict) -> dict[str, Any]:
    return {
        "races": check.raced,
        "failed": check.failed,
        "clearance": check.clearance,
        "margin_broken": sum(clearance < check.margin for clearance in check.clearances),
    }


def describe(tuned: Tuned, chosen: Chosen, file: Path) -> dict[str, Any]:
    """One selected setup on the check seeds."""
    check = chosen.check
    setup = Setup(file.stem, chosen.trial.given, str(file), driver=tuned.session.driver)
    return {
        "file": str(file),
        "trial": chosen.trial.number,
        "lap": check.lap,
        "lap_in_search": chosen.trial.verdict.lap,
        "less": None if check.lap is None else tuned.less(chosen),
        **_safety(check),
        "values": {f"{section}.{name}": value for (section, name), value in chosen.trial.given.items()},
        "rules": [asdict(rule) for rule in check_limits(setup, tuned.session.car)],
    }
