"""Random tracks like those of real races: straights, hairpins and S curves of varying width."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from firstlap.common.errors import InputError
from firstlap.tracks.assemble import assemble
from firstlap.tracks.corridor import corner_line, corridor_walls
from firstlap.tracks.medial import curvature, resample_closed
from firstlap.tracks.track import FloatArray, Track

Cell = tuple[int, int]
LENGTH = (30.0, 100.0)
MIN_RADIUS = 1.0
WIDTH = (1.2, 3.0)
LANE = 2.6
PIPE = 0.12
ATTEMPTS = 60


def random_track(seed: int) -> Track:
    """A drivable track, 30 to 100 m long and 1.2 to 3 m wide, deterministic for a `seed` (0 or more).

    A seed that gives no drivable track in `ATTEMPTS` attempts gets a rounded rectangle.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    name = f"random:{seed}"
    for attempt in range(ATTEMPTS):
        track = _attempt(generator, name, bend=1.0 - attempt / ATTEMPTS)
        if track is not None:
            return replace(track.reversed(), notes=[]) if generator.random() < 0.5 else track
    return _plain(generator, name)


def _plain(generator: np.random.Generator, name: str) -> Track:
    """A random rounded rectangle of 30 to 60 m; always drivable."""
    long, broad, radius, half = generator.uniform((11.0, 6.0, 1.6, 0.8), (19.0, 10.0, 2.6, 1.2))
    at = np.array([(0.0, 0.0), (long, 0.0), (long, broad), (0.0, broad)])
    line = corner_line(np.column_stack([at, np.full(4, radius), np.ones((4, 2))]), name)[:, :2]
    line = resample_closed(line, 0.05)
    left, right = corridor_walls(np.column_stack([line, np.full((len(line), 2), half)]), name)
    return assemble(name, [left], [right], [], source=name)


def _attempt(generator: np.random.Generator, name: str, bend: float) -> Track | None:
    corners = _outline(generator)
    try:
        line = corner_line(_rounded(generator, corners), name)[:, :2]
        line = resample_closed(_bent(generator, line, bend), 0.05)
        line = resample_closed(gaussian_filter1d(line, 6.0, axis=0, mode="wrap"), 0.05)
        length = 0.05 * len(line)
        radius = 1.0 / float(np.abs(gaussian_filter1d(curvature(line), 3.0, mode="wrap")).max())
        if not LENGTH[0] <= length <= LENGTH[1] or radius < MIN_RADIUS:
            return None
        widths = _widths(generator, line)
        left, right = corridor_walls(np.column_stack([line, widths]), name)
        track = assemble(name, [left], [right], [], source=name)
    except InputError:
        return None
    radius = 1.0 / float(np.abs(gaussian_filter1d(curvature(track.centerline), 1.0, mode="wrap")).max())
    fits = LENGTH[0] <= track.length <= LENGTH[1] and track.width_summary()[0] >= WIDTH[0] - 0.05
    return track if fits and radius >= MIN_RADIUS - 0.05 else None


def _outline(generator: np.random.Generator) -> FloatArray:
    """Corners (N, 2), in lanes, of the path once around a random tree; each branch gives a hairpin."""
    size = int(generator.integers(3, 9))
    shape = (int(generator.integers(2, 5)), int(generator.integers(2, 4)))
    tree: list[Cell] = [(0, 0)]
    edges: set[tuple[Cell, Cell]] = set()
    for _ in range(200):
        if len(tree) >= min(size, shape[0] * shape[1]):
            break
        cell = tree[int(generator.integers(max(0, len(tree) - 3), len(tree)))]
        dx, dy = ((1, 0), (0, 1), (-1, 0), (0, -1))[int(generator.integers(4))]
        grown = (cell[0] + dx, cell[1] + dy)
        if 0 <= grown[0] < shape[0] and 0 <= grown[1] < shape[1] and grown not in tree:
            tree.append(grown)
            edges |= {(cell, grown), (grown, cell)}
    return _walk_around(set(tree), edges)


def _walk_around(tree: set[Cell], edges: set[tuple[Cell, Cell]]) -> FloatArray:
    """Walks counterclockwise around a tree on cells of 2 x 2 lanes, keeping it on the left."""
    start = (2 * min(tree)[0], 2 * min(tree)[1])
    steps = ((1, 0), (0, 1), (-1, 0), (0, -1))

    def passable(a: Cell, b: Cell) -> bool:
        cell_a, cell_b = (a[0] // 2, a[1] // 2), (b[0] // 2, b[1] // 2)
        return cell_b in tree and (cell_a == cell_b or (cell_a, cell_b) in edges)

    corners, at, heading = [start], (start[0] + 1, start[1]), 0
    while at != start:
        for turn in (-1, 0, 1):
            step = steps[(heading + turn) % 4]
            if passable(at, (at[0] + step[0], at[1] + step[1])):
                break
        if turn != 0:
            corners.append(at)
        heading = (heading + turn) % 4
        at = (at[0] + step[0], at[1] + step[1])
    return np.array(corners, dtype=np.float64)


def _rounded(generator: np.random.Generator, corners: FloatArray) -> FloatArray:
    """Corners (N, 5) for `corner_line`: random lane spacing, in m, and random radii that fit."""
    meters = np.empty_like(corners)
    for axis in (0, 1):
        lanes = int(corners[:, axis].max()) + 1
        at = np.concatenate([[0.0], np.cumsum(LANE * generator.uniform(0.92, 1.7, lanes - 1))]) if lanes > 1 else [0.0]
        meters[:, axis] = np.asarray(at)[corners[:, axis].astype(int)]
    run = np.hypot(*(np.roll(meters, -1, axis=0) - meters).T)
    largest = 0.5 * np.minimum(run, np.roll(run, 1)) - 0.01
    radius = np.minimum(largest, generator.uniform(1.15, 2.8, len(largest)))
    return np.column_stack([meters, radius, np.ones((len(radius), 2))])


def _bent(generator: np.random.Generator, line: FloatArray, bend: float) -> FloatArray:
    """The line (N, 2) after a smooth random deformation, so that corners are not right angles."""
    bent = line.copy()
    for _ in range(4):
        wave = 2.0 * np.pi / generator.uniform(7.0, 16.0)
        angle, phase, direction = generator.uniform(0.0, 2.0 * np.pi, 3)
        height = bend * generator.uniform(0.08, 0.2) / wave
        along = line @ np.array([np.cos(angle), np.sin(angle)])
        bent += np.outer(height * np.sin(wave * along + phase), [np.cos(direction), np.sin(direction)])
    turn = generator.uniform(0.0, 2.0 * np.pi)
    return np.asarray(bent @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]))


def _widths(generator: np.random.Generator, line: FloatArray) -> FloatArray:
    """(N, 2) width right and left: smooth and random, limited by the next lane and the curvature."""
    wish = gaussian_filter1d(generator.normal(size=(len(line), 2)), 40.0, axis=0, mode="wrap")
    wish = 0.95 + 0.28 * wish / wish.std(axis=0)
    limit = np.minimum(0.5 * WIDTH[1], 0.5 * (_next_lane(line) - PIPE))
    bend = gaussian_filter1d(curvature(line), 6.0, mode="wrap")
    inside = np.column_stack([np.maximum(-bend, 0.0), np.maximum(bend, 0.0)])
    widths = np.clip(wish, 0.5 * WIDTH[0], np.minimum(limit, 0.92 / np.maximum(inside, 1e-3)))
    return np.minimum(gaussian_filter1d(widths, 8.0, axis=0, mode="wrap"), limit)


def _next_lane(line: FloatArray) -> FloatArray:
    """(N, 2) distance to the nearest other part of the line, right and left, at most 10 m."""
    coarse = line[::4]
    offset = coarse[None, :, :] - line[:, None, :]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    apart = np.abs(np.arange(len(line))[:, None] - 4 * np.arange(len(coarse))[None, :])
    apart = np.minimum(apart, len(line) - apart) * 0.05
    distance[apart < np.maximum(2.0, 1.4 * distance)] = 10.0
    tangent = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
    cross = tangent[:, None, 0] * offset[..., 1] - tangent[:, None, 1] * offset[..., 0]
    right = np.where(cross < 0, distance, 10.0).min(axis=1)
    return np.column_stack([right, np.where(cross > 0, distance, 10.0).min(axis=1)])
