"""The rules of the method that can be turned off, each by values of its parameters that mean off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firstlap.common.errors import InputError


@dataclass(frozen=True)
class Rule:
    """One rule. off: the assignments that turn it off. lines: of code that would go with it, counted by hand."""

    name: str
    off: str
    lines: int

    @property
    def assignments(self) -> list[str]:
        """As of --set."""
        return self.off.split()


RULES = (
    Rule("deskew", "deskew=0", 14),
    Rule("body mask", "mask_range=0", 3),
    Rule("weighted mean of distances", "mean_factor=0", 4),
    Rule("merging", "merge_distance=0", 10),
    Rule("elimination: small", "min_chord=0 min_points=1", 4),
    Rule("elimination: far", "max_nearest=30", 2),
    Rule("seen through gaps", "seen_through=0", 30),
    Rule("small sections keep their side", "small_points=2048", 6),
    Rule("labels from history", "past_weight=0", 6),
    Rule("labels from path and trail", "path_radius=0", 24),
    Rule("one-sided splits score less", "one_sided_score=1", 3),
    Rule("gap's fit to the track width", "fit_share=0", 2),
    Rule("hole in one wall", "hole_score=1", 32),
    Rule("dead end", "both_share=1", 6),
    Rule("chain gap", "chain_gap=20", 12),
    Rule("third split candidate", "split_candidates=2", 0),
    Rule("second and third split candidate", "split_candidates=1", 30),
    Rule("other splits only in doubt", "line_enough=10", 2),
    Rule("side consistency", "side_change_score=1", 16),
    Rule("clearance score", "clear_score_min=1", 15),
    Rule("turning back scores less", "turn_back_score=1", 2),
    Rule("turned car", "against_heading=-1", 18),
    Rule("occluded walls", "memory_time=0", 75),
    Rule("width: moving average", "width_window=1", 8),
    Rule("width: memory", "width_gain=0", 10),
    Rule("width: wide pairs do not count", "width_max=10", 8),
    Rule("line of sight past wall ends", "sight_step=30", 70),
    Rule("line between two lines of sight", "sight_length=0", 14),
    Rule("apex width", "apex_width=0", 5),
    Rule("wall bends across", "bend_gain=0", 4),
    Rule("way on past an end", "way_on_share=0", 25),
    Rule("straights between samples", "wall_step=0", 18),
    Rule("wall end stands for nothing", "end_slack=1", 3),
    Rule("seed ahead of the car", "seed_reach=0", 4),
    Rule("seed wall check", "seed_wall=0", 15),
    Rule("meets itself", "loop_length=30", 10),
    Rule("trail bars the way back", "trail_against=-1", 32),
    Rule("smoothing", "smoothing_iterations=0", 30),
    Rule("smoothing between walls", "smoothing_block=0", 18),
    Rule("join", "join_distance=0", 42),
    Rule("join: time", "join_time=0", 2),
    Rule("Opheim", "opheim_min=0", 38),
    Rule("curvature held at the end", "end_hold=0", 5),
    Rule("minimum curvature path", "bend_passes=0", 140),
    Rule("no cutting of tight bends", "bend_radius=0", 18),
    Rule("holding the last path", "hold_time=0", 8),
    Rule("speed scale", "scale_limit=0", 150),
)


def together(rules: Sequence[Rule]) -> Rule:
    """All of these off at once, as one row."""
    names = ", ".join(rule.name for rule in rules)
    return Rule(names, " ".join(rule.off for rule in rules), sum(rule.lines for rule in rules))


def chosen_rules(names: Sequence[str] | None) -> list[Rule]:
    """The rules of these names, all for none. Raises InputError."""
    known = {rule.name: rule for rule in RULES}
    for name in names or ():
        if name not in known:
            raise InputError(f"--rule {name[:60]}: no such rule; expected {', '.join(known)}")
    return [rule for rule in RULES if not names or rule.name in names]
