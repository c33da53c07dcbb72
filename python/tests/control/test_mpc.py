"""Predictive control along a line, with valid and absurd states, and with a failing solver."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from firstlap._core import VehicleState
from firstlap.config.car_file import load_car
from firstlap.control.mpc.controller import Controller
from firstlap.control.mpc.horizon import ACCEL, COMMAND, OFFSET, VX, WHEEL, exponential
from firstlap.control.mpc.model import SCALARS, loop_acceleration, model_of, motion
from firstlap.control.mpc.observer import Commands, predicted
from firstlap.control.mpc.params import MPC_FIELDS, MpcParams
from firstlap.control.mpc.pattern import Pattern
from firstlap.planning.raceline.line import RaceLine, line_through
from firstlap.tracks.track import Track

pytest.importorskip("piqp")

CAR = load_car("default")
PARAMS = MpcParams(time_limit=10.0)
"""With a long time limit, so that plans are not late on a busy machine."""
DT = 0.025


def stadium(straight: float = 40.0, radius: float = 6.0) -> np.ndarray:
    """(N, 2) two straights along x, joined by half circles, counterclockwise, starting in the middle of the lower
    straight."""
    s = np.arange(0.0, 2.0 * straight + 2.0 * math.pi * radius - 0.05, 0.1)
    x, y = np.empty_like(s), np.empty_like(s)
    for i, way in enumerate((s + 0.5 * straight) % (2.0 * straight + 2.0 * math.pi * radius)):
        turn = math.pi * radius
        if way < straight:
            x[i], y[i] = way, 0.0
        elif way < straight + turn:
            angle = (way - straight) / radius
            x[i], y[i] = straight + radius * math.sin(angle), radius * (1.0 - math.cos(angle))
        elif way < 2.0 * straight + turn:
            x[i], y[i] = straight - (way - straight - turn), 2.0 * radius
        else:
            angle = (way - 2.0 * straight - turn) / radius
            x[i], y[i] = -radius * math.sin(angle), radius * (1.0 + math.cos(angle))
    return np.column_stack([x, y])


def road(points: np.ndarray, half: float = 2.0) -> Track:
    ahead = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    normal = np.column_stack([-ahead[:, 1], ahead[:, 0]]) / np.hypot(*ahead.T)[:, None]
    left, right = points + half * normal, points - half * normal
    walls = [np.vstack([wall, wall[:1]]) for wall in (left, right)]
    width = np.full(len(points), half)
    return Track("stadium", walls, ["left", "right"], [True] * 2, [True] * 2, points, width, width)


POINTS = stadium()
TRACK = road(POINTS)
LINE = line_through("stadium", POINTS, np.full(len(POINTS), 4.0), "test")


def controller(params: MpcParams = PARAMS, line: RaceLine = LINE, track: Track = TRACK) -> Controller:
    return Controller(line, track, CAR, params)


def drive(control: Controller, body: tuple[float, ...], seconds: float, step=None) -> tuple[np.ndarray, list[str]]:
    """States (K, 7) and statuses while the controller drives its own model."""
    model, commands, path, output = control.model, Commands(), [], []
    time = 0.0
    for index in range(round(seconds / DT)):
        pose, measured = body[:3], (body[3], body[5], body[6])
        given, *felt = step(index, pose, measured) if step else (pose, *measured)
        found = control.step(given, VehicleState(*felt), DT)
        output.append(found.status)
        assert math.isfinite(found.speed)
        assert found.speed >= 0.0
        assert abs(found.steering_angle) <= model.steering_limit + 1e-12
        commands.give_speed(time + model.speed_delay, found.speed)
        commands.give_steering(time + model.steering_delay, found.steering_angle)
        body = predicted(model, body, commands, time, time + DT)
        time += DT
        path.append(body)
    return np.array(path), output


def start(offset: float = 0.0, speed: float = 4.0) -> tuple[float, ...]:
    x, y = POINTS[0]
    return (x, y + offset, 0.0, speed, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("offset", [-0.4, 0.1, 0.4])
def test_the_car_converges_to_a_straight_line_without_overshoot(offset):
    path, output = drive(controller(), start(offset), 2.5)
    assert set(output) == {"ok"}
    assert abs(path[-1, 1]) < 0.02
    assert (path[:, 1] * np.sign(offset)).min() > -0.05
    assert path[:, 3] == pytest.approx(4.0, abs=0.2)


def test_it_laps_a_stadium_at_the_speeds_of_the_line():
    control = controller()
    path, output = drive(control, start(), 14.0)
    assert set(output) == {"ok"}
    offsets = [control.table.locate(x, y, yaw, None)[1] for x, y, yaw in path[:, :3]]
    assert np.abs(offsets).max() < 0.08
    assert path[:, 3].mean() == pytest.approx(4.0, abs=0.05)


def test_a_mirrored_state_mirrors_the_steering():
    mirror = np.array([1.0, -1.0])
    other_track = road(POINTS * mirror)
    other_line = line_through("mirrored", POINTS * mirror, LINE.speed, "test")
    one, other = controller(), controller(line=other_line, track=other_track)
    state = (POINTS[100, 0], POINTS[100, 1] + 0.2, 0.1)
    for _ in range(4):
        a = one.step(state, VehicleState(4.0, 0.3, 0.05), DT)
        b = other.step((state[0], -state[1], -state[2]), VehicleState(4.0, -0.3, -0.05), DT)
        assert b.speed == pytest.approx(a.speed, abs=1e-3)
        assert b.steering_angle == pytest.approx(-a.steering_angle, abs=1e-3)


def test_plans_keep_to_the_limits_of_the_actuators():
    control = controller()
    for offset in (-1.0, 1.0):
        control.reset()
        control.step((POINTS[150, 0], POINTS[150, 1] + offset, 0.6), VehicleState(7.0, -1.0, 0.3), DT)
        plan, model = control.plan, control.model
        assert np.abs(plan.inputs[COMMAND]).max() <= model.steering_limit + 1e-4
        assert np.abs(plan.inputs[COMMAND] - plan.states[WHEEL, :-1]).max() <= model.servo_reach + 1e-3
        assert plan.inputs[ACCEL].max() <= model.most_accel + 1e-3
        assert plan.inputs[ACCEL].min() >= -model.most_brake - 1e-3


def test_plans_stay_off_the_walls_beside_the_line():
    narrow = road(POINTS, 0.6)
    beside = line_through("beside", POINTS - np.array([0.0, 0.0]), LINE.speed, "test")
    control = controller(line=beside, track=narrow)
    drive(control, start(0.3), 0.2)
    room = 0.6 - 0.155 - PARAMS.margin
    assert np.abs(control.plan.states[OFFSET]).max() < room + 0.02


def test_it_starts_from_standstill_and_slows_before_the_bend():
    fast = np.where(np.abs(np.gradient(np.unwrap(LINE.path.heading))) > 1e-3, 4.0, 7.0)
    control = controller(line=line_through("fast", POINTS, fast, "test"))
    path, output = drive(control, start(speed=0.0), 7.0)
    assert set(output) == {"ok"}
    assert path[:, 3].max() > 5.0
    offsets = [control.table.locate(x, y, yaw, None)[1] for x, y, yaw in path[:, :3]]
    assert np.abs(offsets).max() < 0.3


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e12])
def test_without_a_pose_the_car_never_moves(bad):
    found = controller().step((bad, 0.0, 0.0), VehicleState(4.0), DT)
    assert found == (0.0, 0.0, "bad_state")


def test_a_lost_pose_is_bridged_and_then_the_car_stops():
    def step(index, pose, measured):
        return ((math.nan, 0.0, 0.0) if index >= 20 else pose, *measured)

    path, output = drive(controller(), start(), 4.0, step)
    bridged = round(PARAMS.patience / DT)
    assert output[:20] == ["ok"] * 20
    assert set(output[20 : 20 + bridged]) == {"holding"}
    assert set(output[21 + bridged :]) == {"no_path"}
    assert path[-1, 3] < 0.05
    assert np.abs(path[:, 1]).max() < 0.3


def test_a_solver_that_fails_leaves_the_last_plan_and_then_a_stop(monkeypatch):
    control = controller()
    solve, calls = control._solver.solve, []

    def sometimes():
        calls.append(0)
        return solve() if len(calls) < 20 else None

    monkeypatch.setattr(control._solver, "solve", sometimes)
    path, output = drive(control, start(0.2), 4.0)
    assert "holding" in output
    assert output[-1] == "no_path"
    assert path[-1, 3] < 0.05
    assert np.abs(path[:, 1]).max() < 0.3


def test_a_solver_that_recovers_is_used_again(monkeypatch):
    control = controller()
    solve, calls = control._solver.solve, []

    def sometimes():
        calls.append(0)
        return None if 20 <= len(calls) < 26 else solve()

    monkeypatch.setattr(control._solver, "solve", sometimes)
    path, output = drive(control, start(0.2), 3.0)
    assert output.count("holding") == 6
    assert output[-1] == "ok"
    assert abs(path[-1, 1]) < 0.03


def test_a_plan_that_comes_late_is_not_used():
    ticks = iter(np.arange(0.0, 1e6, 1.0))
    control = Controller(LINE, TRACK, CAR, MpcParams(time_limit=0.5), clock=lambda: float(next(ticks)))
    _, output = drive(control, start(), 1.0)
    assert output[0] == "ok"
    assert output[1] == "holding"
    assert output[-1] == "no_path"


@pytest.mark.parametrize(
    "state",
    [
        (4.0, 50.0, 0.0),
        (4.0, 0.0, 3.0),
        (40.0, -20.0, 0.4),
        (-3.0, 0.0, 0.0),
        (math.nan, math.nan, math.nan),
        (1e9, 1e9, -1e9),
    ],
)
def test_absurd_states_give_commands_within_limits(state):
    control = controller()
    for pose in ((20.0, 0.0, 0.0), (20.0, 1.8, 1.5), (20.0, 0.0, 3.1), (400.0, 0.0, 0.0), (20.0, 0.0, 1e5)):
        for _ in range(3):
            found = control.step(pose, VehicleState(*state), DT)
            assert math.isfinite(found.speed)
            assert 0.0 <= found.speed <= 60.0
            assert abs(found.steering_angle) <= control.model.steering_limit


@pytest.mark.parametrize("pose", [(20.0, 8.0, 0.0), (20.0, 0.0, 3.1)])
def test_far_off_or_against_the_line_the_car_stops(pose):
    control = controller()
    found = control.step(pose, VehicleState(2.0), DT)
    assert found.status == "no_path"
    assert found.speed < 2.0


def test_the_model_turns_without_slip_at_walking_pace():
    model = model_of(CAR)
    vx, vy, rate = 0.5, 0.0, 0.0
    for _ in range(2000):
        _, ay, spin = motion(model, vx, vy, rate, 0.2, 0.0, SCALARS)
        vy, rate = vy + 1e-3 * ay, rate + 1e-3 * spin
    assert rate == pytest.approx(vx * math.tan(0.2) / model.wheelbase, rel=0.02)


def test_grip_along_is_that_of_the_axle_that_slides_first():
    model = model_of(CAR)
    brake = model.grip.brake
    rear_load = model.mass * (9.81 * model.l_f - brake * model.height) / model.wheelbase
    assert (1.0 - model.split) * model.mass * brake == pytest.approx(model.mu * rear_load)
    assert model.grip.drive < model.grip.lateral


def test_the_speed_loop_is_what_the_command_inverts():
    model = model_of(CAR)
    assert loop_acceleration(model, 3.0, 3.0 + 2.0 / model.gain_up) == pytest.approx(2.0)
    assert loop_acceleration(model, 3.0, 0.0) == -model.most_brake


def test_the_exponential_is_scipy_s():
    from scipy.linalg import expm

    random = np.random.default_rng(1)
    slopes = random.normal(0.0, 20.0, (6, 4, 4))
    e, integral = exponential(slopes, 0.03)
    for slope, found, area in zip(slopes, e, integral, strict=True):
        whole = expm(0.03 * np.block([[slope, np.eye(4)], [np.zeros((4, 8))]]))
        assert found == pytest.approx(whole[:4, :4], abs=2e-4)
        assert area == pytest.approx(whole[:4, 4:], abs=2e-5)


def test_a_pattern_adds_what_falls_on_one_place():
    pattern = Pattern(3, 3)
    diagonal, corner = pattern.group([0, 1, 2], [0, 1, 2]), pattern.group([0, 2], [2, 2])
    pattern.freeze()
    pattern.values[diagonal], pattern.values[corner] = 1.0, [5.0, 7.0]
    assert pattern.fill().toarray().tolist() == [[1.0, 0.0, 5.0], [0.0, 1.0, 0.0], [0.0, 0.0, 8.0]]


def test_a_plan_knows_no_speed_below_zero_when_it_stops():
    control = controller(replace(PARAMS, speed_scale=0.1))
    path, _ = drive(control, start(), 3.0)
    assert path[-1, 3] == pytest.approx(0.4, abs=0.1)
    assert control.plan.states[VX].min() > -0.1


def test_every_default_is_within_its_range():
    for field in MPC_FIELDS.fields:
        MPC_FIELDS.check(field, field.default, "default")
