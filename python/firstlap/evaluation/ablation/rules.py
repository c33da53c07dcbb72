"""The rules of the method that can be turned off, each by the values of its parameters that disable it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firstlap.common.errors import InputError
from firstlap.config.parameters import Value
from firstlap.config.setup_file import Setup


@dataclass(frozen=True)
class Rule:
    """One rule.

    off: assignments that turn it off. lines: number of lines of code that implement it, counted by hand. published: a
    step of the paper, not an addition of ours.
    """

    name: str
    off: str
    lines: int
    published: bool = False

    @property
    def assignments(self) -> list[str]:
        """The assignments as for --set."""
        return self.off.split()


RULES = (
    Rule("deskew", "deskew=0", 14),
    Rule("body mask", "mask_range=0", 3),
    Rule("distance threshold from a weighted mean", "mean_factor=0", 4, published=True),
    Rule("merging", "merge_distance=0", 10, published=True),
    Rule("eliminate small sections", "min_chord=0 min_points=1", 4, published=True),
    Rule("eliminate far sections", "max_nearest=30", 2, published=True),
    Rule("drop what is seen through gaps", "seen_through=0", 30),
    Rule("small sections keep their side", "small_points=2048", 6),
    Rule("labels from history", "past_weight=0", 6),
    Rule("labels from path and trail", "path_radius=0", 24),
    Rule("one-sided split penalty", "one_sided_score=1", 3),
    Rule("gap width score", "fit_share=0", 2),
    Rule("hole in one wall", "hole_score=1", 32),
    Rule("maximum gap in a wall", "chain_gap=20", 12),
    Rule("third split candidate", "split_candidates=2", 0),
    Rule("second and third split candidate", "split_candidates=1", 30),
    Rule("other splits only if the first is short", "line_enough=10", 2),
    Rule("side consistency", "side_change_score=1", 16),
    Rule("clearance score", "clear_score_min=1", 15),
    Rule("turn-back penalty", "turn_back_score=1", 2),
    Rule("turned car", "against_heading=-1", 18),
    Rule("occluded walls", "memory_time=0", 75),
    Rule("width: moving average", "width_window=1", 8, published=True),
    Rule("width: memory", "width_gain=0", 10),
    Rule("width: ignore wide pairs", "width_max=10", 8),
    Rule("past a wall's end", "end_step=30", 28),
    Rule("line of sight past wall ends", "sight_step=30", 70),
    Rule("line between two lines of sight", "sight_length=0", 14),
    Rule("apex width", "apex_width=0", 5),
    Rule("wall bends across the track", "bend_gain=0", 4),
    Rule("continue past a wall end", "way_on_share=0", 25),
    Rule("straight walls between samples", "wall_step=0", 18),
    Rule("wall end supports nothing beyond it", "end_slack=1", 3),
    Rule("seed ahead of the car", "seed_reach=0", 4),
    Rule("seed wall check", "seed_wall=0", 15),
    Rule("line must not meet itself", "loop_length=30", 10),
    Rule("no line back along the trail", "trail_against=-1", 32),
    Rule("smoothing", "smoothing_iterations=0", 30, published=True),
    Rule("smoothing between walls", "smoothing_block=0", 18),
    Rule("join", "join_distance=0", 42),
    Rule("join: time", "join_time=0", 2),
    Rule("Opheim", "opheim_min=0", 38, published=True),
    Rule("curvature held at the end", "end_hold=0", 5),
    Rule("minimum-curvature path", "bend_passes=0", 140),
    Rule("hold the previous path", "hold_time=0", 8),
    Rule("speed scale", "scale_limit=0", 150),
    Rule("steady-state yaw", "k_ag=0", 1),
    Rule("friction ellipse", "friction_ellipse=false", 12),
)


def additions(paper: Setup, ours: Setup) -> list[Rule]:
    """Our additions on the way from one setup to the other, one more in each row, in the order of the method's steps.

    Each row's assignments turn on its own addition and those before it, with the values of `ours`.
    """
    rows: list[Rule] = []
    turned_on: dict[str, str] = {}
    for rule in RULES:
        names = [text.partition("=")[0] for text in rule.assignments]
        new = {name: written(ours.get(name)) for name in names if paper.get(name) != ours.get(name)}
        if rule.published or not new.keys() - turned_on.keys():
            continue
        turned_on |= new
        rows.append(Rule(f"+ {rule.name}", " ".join(map("=".join, turned_on.items())), rule.lines))
    return rows


def written(value: Value) -> str:
    """A value as --set takes it."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def together(rules: Sequence[Rule]) -> Rule:
    """Combines rules that are turned off together, as one row."""
    names = ", ".join(rule.name for rule in rules)
    return Rule(names, " ".join(rule.off for rule in rules), sum(rule.lines for rule in rules))


def chosen_rules(names: Sequence[str] | None) -> list[Rule]:
    """The rules of these names; all for None. Raises InputError."""
    known = {rule.name: rule for rule in RULES}
    for name in names or ():
        if name not in known:
            raise InputError(f"--rule {name[:60]}: no such rule; expected {', '.join(known)}")
    return [rule for rule in RULES if not names or rule.name in names]
