"""Robots as mechanisms: what the models weigh, how they stand, and how a bad one is refused."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

import surefoot as sf
from small_biped import small_urdf, tetrahedron, write_small_biped
from surefoot.robot.legs import NominalPose, measure_pose, one_foot_torque
from surefoot.robot.model_file import DATA_PACKAGES, missing_packages
from surefoot.robot.multibody import Multibody, load_multibody
from surefoot.robot.paper_biped import paper_biped_mjcf
from surefoot.robot.robot import Robot, parse_robot, preset_text

PRESETS = [
    robot.name
    for robot in map(sf.load_robot, sf.preset_names())
    if robot.body is not None and not missing_packages(robot)
]
PAPER = preset_text("paper-biped")


@cache
def mechanism_of(name: str) -> Multibody:
    return load_multibody(sf.load_robot(name))


@cache
def pose_of(name: str) -> NominalPose:
    return measure_pose(mechanism_of(name))


def paper_with(**changes) -> Robot:
    """The paper's biped with another `[body]`."""
    robot = sf.load_robot("paper-biped")
    assert robot.body is not None
    table = {name: getattr(robot.body, name) for name in robot.body.__struct_fields__}
    return robot.replace(body=type(robot.body)(**{**table, **changes}))


def test_all_presets_are_here_when_their_packages_are() -> None:
    assert "paper-biped" in PRESETS
    assert len(PRESETS) in (1, 2, 3, 4)


@pytest.mark.parametrize("name", PRESETS)
def test_file_and_model_agree(name: str) -> None:
    mechanism, pose = mechanism_of(name), pose_of(name)
    robot = mechanism.robot
    assert mechanism.mass == pytest.approx(robot.mass, rel=1e-3)
    assert pose.com[2] == pytest.approx(robot.com_height, rel=2e-3)
    assert pose.spacing == pytest.approx(robot.hip, abs=1e-4)


def on_the_floor(mechanism: Multibody, lower: float, bend: float = 0.0) -> set[str]:
    """What touches the floor if the robot is that much lower, knees bent further."""
    data = mujoco.MjData(mechanism.model)
    data.qpos[:] = mechanism.nominal
    data.qpos[2] -= lower
    for name in mechanism.joint_names:
        if "knee" in name:
            data.qpos[mechanism.model.joint(name).qposadr[0]] += bend
    mujoco.mj_forward(mechanism.model, data)
    pairs = [{mechanism.model.geom(one).name for one in contact.geom} for contact in data.contact]
    return {name for pair in pairs if "floor" in pair for name in pair - {"floor"}}


# The joints of TALOS have numbers and no names: none is found to be bent.
@pytest.mark.parametrize("name", [one for one in PRESETS if one != "talos"])
def test_a_sole_that_sinks_in_is_no_fall_and_a_knee_on_the_floor_is(name: str) -> None:
    mechanism = mechanism_of(name)
    assert on_the_floor(mechanism, 0.015) == {"left_sole", "right_sole"}
    knees = on_the_floor(mechanism, 0.62 * mechanism.robot.com_height, 0.6)
    assert len(knees - {"left_sole", "right_sole"}) == 2
    assert not any("shank" in one or "knee_link" in one for one in knees)


@pytest.mark.parametrize("name", PRESETS)
def test_it_stands_flat_under_its_com(name: str) -> None:
    pose = pose_of(name)
    assert pose.soles[:, [0, 2]] == pytest.approx(np.zeros((2, 2)), abs=1e-9)
    assert pose.axes == pytest.approx(np.array([np.eye(3)] * 2), abs=1e-4)
    assert np.abs(pose.com[:2]).max() < 5e-3


@pytest.mark.parametrize("name", PRESETS)
def test_knees_leave_room_for_the_longest_step(name: str) -> None:
    for leg in pose_of(name).legs:
        assert 0.89 < leg.length / leg.straight < 0.935
        assert leg.step_reach > sf.load_robot(name).gait.step_x[1]


@pytest.mark.parametrize("name", PRESETS)
def test_the_right_leg_mirrors_the_left(name: str) -> None:
    mechanism, data = mechanism_of(name), mechanism_of(name).data()
    model, (left, right) = mechanism.model, pose_of(name).legs
    mirror = np.array([1.0, -1.0, 1.0])
    ones, others = list(left.links), list(right.links)
    assert model.body_mass[ones] == pytest.approx(model.body_mass[others], rel=1e-9)
    assert data.xpos[ones] * mirror == pytest.approx(data.xpos[others], abs=1e-4)
    assert data.xipos[ones] * mirror == pytest.approx(data.xipos[others], abs=1e-3)
    order = {name: place for place, name in enumerate(mechanism.joint_names)}
    pair = [[order[joint] for joint in leg.joints] for leg in (left, right)]
    assert mechanism.torque[pair[0]] == pytest.approx(mechanism.torque[pair[1]])
    assert mechanism.speed[pair[0]] == pytest.approx(mechanism.speed[pair[1]])
    # A mirrored load: torques about y are the same, those about x and z turn around.
    axes = data.xaxis[mechanism.motors[pair[0]]]
    signs = np.where(np.abs(axes[:, 1]) > 0.9, 1.0, -1.0)
    on_left, on_right = (one_foot_torque(mechanism, foot) for foot in (0, 1))
    assert on_left[pair[0]] == pytest.approx(signs * on_right[pair[1]], abs=0.02 * mechanism.mass)


@pytest.mark.parametrize("name", PRESETS)
def test_every_leg_has_its_motors_and_their_limits(name: str) -> None:
    mechanism, pose = mechanism_of(name), pose_of(name)
    passive = mechanism.body.ankle_roll == "passive"
    assert [len(leg.joints) for leg in pose.legs] == [5 if passive else 6] * 2
    assert len(mechanism.passive_dofs) == (8 if passive else 6)
    assert np.isfinite(mechanism.torque).all()
    assert np.isfinite(mechanism.speed).all()
    assert (pose.load < 0.5 * mechanism.torque).all()
    limits = mechanism.model.jnt_actfrcrange[mechanism.motors]
    assert limits == pytest.approx(np.outer(mechanism.torque, (-1.0, 1.0)))


# Hip (yaw, roll, pitch), knee, ankle (pitch, roll): torque [N m] and speed [rad/s] of the makers'
# models: unitree_ros (H1, G1), talos_reduced.urdf.
DATA_SHEETS = {
    "h1": ([200, 200, 200, 300, 40], [23, 23, 23, 14, 9]),
    "g1": ([88, 139, 88, 139, 50, 50], [32, 20, 32, 20, 37, 37]),
    "talos": ([100, 160, 160, 300, 160, 100], [3.87, 5.8, 5.8, 7, 5.8, 4.8]),
}


@pytest.mark.parametrize("name", [name for name in PRESETS if name in DATA_SHEETS])
def test_limits_are_those_of_the_makers(name: str) -> None:
    mechanism = mechanism_of(name)
    torque, speed = DATA_SHEETS[name]
    assert mechanism.torque.tolist() == pytest.approx(torque * 2)
    assert mechanism.speed.tolist() == pytest.approx(speed * 2)


@pytest.mark.skipif("talos" not in PRESETS, reason="example-robot-data is not installed")
def test_the_base_of_a_urdf_keeps_its_mass() -> None:
    mechanism = mechanism_of("talos")
    assert mechanism.model.body_mass[mechanism.base] == pytest.approx(13.538, abs=1e-3)
    assert mechanism.mass == pytest.approx(90.27, abs=0.01)
    assert mechanism.unseen == ()
    assert mechanism.model.nmesh > 20


def test_standing_on_one_foot_accelerates_as_the_pendulum_does() -> None:
    # Forward dynamics, which the torques were not computed with: every joint stays at rest.
    robot = paper_with(locked=("*_ankle_roll",), ankle_roll="actuated")
    mechanism = load_multibody(robot)
    model, data = mechanism.model, mechanism.data()
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    lever = data.subtree_com[mechanism.base] - data.site_xpos[mechanism.soles[0]]
    slope = robot.gravity * lever / lever[2]
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, jacobian, None, mechanism.soles[0])
    data.qfrc_applied[:] = jacobian.T @ (mechanism.mass * slope)
    data.qfrc_applied[mechanism.motor_dofs] += one_foot_torque(mechanism, 0)
    mujoco.mj_forward(model, data)
    assert data.qacc[:3] == pytest.approx([slope[0], slope[1], 0.0], abs=1e-9)
    assert data.qacc[3:] == pytest.approx(np.zeros(model.nv - 3), abs=1e-9)
    assert slope[1] == pytest.approx(-(robot.omega**2) * robot.hip / 2, rel=1e-2)


def test_a_locked_joint_is_held_where_the_posture_says() -> None:
    angles = {"*_hip_yaw": 0.3, "left_knee": 0.5, "right_knee": 0.6}
    free = load_multibody(paper_with(posture=angles))
    held = load_multibody(paper_with(posture=angles, locked=("*_hip_yaw", "right_*_pitch")))
    assert held.model.nv == free.model.nv - 4
    data, other = free.data(), held.data()
    names = [free.model.body(body).name for body in range(1, free.model.nbody)]
    for name in names:
        assert other.body(name).xpos == pytest.approx(data.body(name).xpos, abs=1e-12)
        assert other.body(name).xmat == pytest.approx(data.body(name).xmat, abs=1e-12)
    assert held.mass == free.mass


def test_a_body_turned_by_angles_is_locked_right_too(tmp_path: Path) -> None:
    # A pivot away from the link's origin, a link turned by euler angles, degrees.
    text = paper_biped_mjcf(0.2, (0.2, 0.11)).replace('angle="radian"', 'angle="degree"')
    text = text.replace("range=", "limited='false' range=")
    arm = (
        '<body name="arm" pos="0 0.3 0.5" euler="20 30 40"><joint name="arm" axis="0 2 1" '
        'pos="0.02 0.03 0.1"/><inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/></body>'
    )
    (tmp_path / "armed.xml").write_text(
        text.replace("</body>\n  </worldbody>", f"{arm}</body></worldbody>")
    )
    body = {"model": str(tmp_path / "armed.xml"), "posture": {"arm": 0.7}}
    free = load_multibody(paper_with(**body))
    held = load_multibody(paper_with(**body, locked=("arm",)))
    places = [each.data().body("arm") for each in (free, held)]
    assert places[1].xpos == pytest.approx(places[0].xpos, abs=1e-12)
    assert places[1].xmat == pytest.approx(places[0].xmat, abs=1e-12)


def test_a_passive_ankle_rolls_about_a_hinge_near_the_ground() -> None:
    # The paper's biped has one in its model; a foot that begins at the ankle gets the same.
    made = mechanism_of("paper-biped")
    ankle = {"feet": ("left_ankle", "right_ankle"), "sole": (0.0, 0.0, -0.08)}
    added = load_multibody(paper_with(locked=("*_ankle_roll",), **ankle))
    for side, site in zip(("left", "right"), made.soles, strict=True):
        heights = []
        for mechanism in (made, added):
            data, hinge = mechanism.data(), mechanism.model.joint(f"{side}_ankle_roll")
            heights.append(data.xanchor[hinge.id] - data.site_xpos[site])
            assert data.xaxis[hinge.id] == pytest.approx([1.0, 0.0, 0.0])
            assert hinge.name not in mechanism.joint_names
        assert heights[0] == pytest.approx([0.0, 0.0, 0.02])
        assert heights[1] == pytest.approx(heights[0])


def test_a_later_pattern_wins_over_an_earlier_one_and_over_the_model() -> None:
    mechanism = load_multibody(
        paper_with(
            torque={"*": 50.0, "left_*": 60.0}, speed={"*_knee": 7.0}, armature={"*_knee": 0.3}
        )
    )
    torque = dict(zip(mechanism.joint_names, mechanism.torque, strict=True))
    speed = dict(zip(mechanism.joint_names, mechanism.speed, strict=True))
    assert (torque["left_knee"], torque["right_knee"]) == (60.0, 50.0)
    assert (speed["left_knee"], speed["left_hip_yaw"]) == (7.0, np.inf)
    armature = mechanism.model.dof_armature[mechanism.motor_dofs]
    assert sorted(set(armature.tolist())) == [0.02, 0.3]


def test_the_generated_model_and_the_same_from_a_file_are_one(tmp_path: Path) -> None:
    # As a file the model is a robot of one's own: read, not generated.
    (tmp_path / "biped.xml").write_text(paper_biped_mjcf(0.2, (0.2, 0.11)))
    text = PAPER.replace('model = "paper-biped"', 'model = "biped.xml"')
    (tmp_path / "biped.toml").write_text(text)
    own, preset = (
        load_multibody(sf.load_robot(name)) for name in (tmp_path / "biped.toml", "paper-biped")
    )
    assert own.joint_names == preset.joint_names
    assert own.nominal.tolist() == preset.nominal.tolist()
    assert own.model.body_inertia.tolist() == preset.model.body_inertia.tolist()


def test_a_urdf_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_small_biped(tmp_path)
    monkeypatch.chdir(path.parent)
    robot = sf.load_robot(path.name)
    monkeypatch.chdir("/")
    mechanism = load_multibody(robot)
    pose = measure_pose(mechanism)
    assert mechanism.mass == pytest.approx(30.0)
    assert pose.com[2] == pytest.approx(robot.com_height, rel=1e-2)
    assert np.abs(pose.com[:2]).max() < 5e-3
    knee = mechanism.joint_names.index("left_knee")
    assert (mechanism.torque[knee], mechanism.speed[knee]) == (120.0, 14.0)
    assert "left_arm" not in mechanism.joint_names
    assert mechanism.unseen == ("package://small_description/meshes/pelvis.dae",)
    assert mechanism.model.nmesh == 1


@pytest.mark.parametrize("folder", ["small_description", "small_description-2.1"])
@pytest.mark.parametrize(
    "name", ["package://small_description/meshes/pelvis.stl", "../meshes/pelvis.stl", "own.stl"]
)
def test_meshes_are_found_from_their_package_and_from_the_model(
    tmp_path: Path, folder: str, name: str
) -> None:
    path = write_small_biped(tmp_path, folder)
    model = path.parent / "model" / "small.urdf"
    model.write_text(small_urdf().replace("package://small_description/meshes/pelvis.stl", name))
    model.with_name("own.stl").write_bytes(tetrahedron())
    assert load_multibody(sf.load_robot(path)).model.nmesh == 1


def test_a_robot_of_ones_own_survives_saving(tmp_path: Path) -> None:
    robot = sf.load_robot(write_small_biped(tmp_path))
    assert robot.body is not None
    assert Path(robot.body.model).is_absolute()
    walk = sf.simulate(sf.HybridController(robot, (0.2, 0.0)), 0.5)
    walk.save(tmp_path / "walk.npz")
    assert sf.load_rollout(tmp_path / "walk.npz").robot == robot


def test_a_models_own_floor_and_names_are_not_in_the_way(tmp_path: Path) -> None:
    text = paper_biped_mjcf(0.2, (0.2, 0.11)).replace(
        "<worldbody>", '<worldbody><geom name="floor" type="plane" size="1 1 1"/><light/>'
    )
    text = text.replace("<freejoint", '<site name="left_sole"/><camera/><light/><freejoint')
    (tmp_path / "scene.xml").write_text(text)
    mechanism = load_multibody(paper_with(model=str(tmp_path / "scene.xml")))
    kinds = mechanism.model.geom_type.tolist()
    assert kinds.count(int(mujoco.mjtGeom.mjGEOM_PLANE)) == 1
    assert mechanism.model.nlight == mechanism.model.ncam == 0


def test_torques_of_actuators_are_read_whatever_they_are(tmp_path: Path) -> None:
    actuators = """<actuator>
        <motor joint="left_knee" gear="3" ctrlrange="-50 40"/>
        <position joint="right_knee" forcerange="-70 70" gear="2" kp="100"/>
        <motor joint="left_hip_yaw" forcerange="-30 30" ctrlrange="-1 1" gear="100"/>
      </actuator></mujoco>"""
    text = paper_biped_mjcf(0.2, (0.2, 0.11)).replace("</mujoco>", actuators)
    (tmp_path / "driven.xml").write_text(text)
    mechanism = load_multibody(paper_with(model=str(tmp_path / "driven.xml"), torque={}))
    torque = dict(zip(mechanism.joint_names, mechanism.torque, strict=True))
    assert (torque["left_knee"], torque["right_knee"]) == (120.0, 140.0)
    assert (torque["left_hip_yaw"], torque["right_hip_yaw"]) == (100.0, np.inf)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('base = "trunk"', 'base = "torso"', r"a body of the model \(trunk, left_thigh.*'torso'"),
        ('base = "trunk"', 'base = "left_shank"', r"outermost body.*write base = \"trunk\""),
        ('"right_foot"]', '"right_fot"]', r"a body of the model.*got 'right_fot'; correct"),
        ('"*_knee" = 0.8', '"*_kne" = 0.8', r"`posture` to name joints.*left_knee.*'\*_kne'"),
        ('"*_knee" = 350.0', '"*knie" = 350.0', r"`torque` to name joints .*'\*knie', which match"),
        ("leg_radius =", 'locked = ["arm*"]\nleg_radius =', r"`locked` to name joints.*'arm\*'"),
        ('model = "paper-biped"', 'model = "no.xml"', r"no file .*no.xml; correct `body.model`"),
        ('model = "paper-biped"', 'model = "none"', r"`model` of the body to be one of paper-"),
        (
            'model = "paper-biped"', 'model = "no.xml"\npackage = "no-such-data"',
            r"the package no-such-data .* it is not installed; run: pip install no-such-data",
        ),
        ("ankle_roll = ", 'ankle_rol = "passive"\nankle_roll = ', r"did you mean `body.ankle_roll"),
        ('"*" = 12.0', '"*" = 0.0', r"`speed` of `\*` to be positive \[rad/s\]; got 0.0"),
    ],
)  # fmt: skip
def test_mistakes_in_the_body_are_named(before: str, after: str, message: str) -> None:
    assert PAPER.count(before) == 1
    with pytest.raises(sf.RobotError, match=message):
        load_multibody(parse_robot(PAPER.replace(before, after), "test.toml"))


def test_a_data_package_that_is_missing_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("surefoot.robot.model_file._is_installed", lambda package: False)
    for name in ("h1", "g1", "talos"):
        robot = sf.load_robot(name)
        assert robot.body is not None
        assert robot.body.package in DATA_PACKAGES
        with pytest.raises(sf.RobotError, match=r"not installed; run: pip install 'surefoot\[rob"):
            load_multibody(robot)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("bad.xml", "<mujoco><worldbody><body", r"a model that MuJoCo can read; got .*bad.xml"),
        ("bad.xml", "<mujoco><option wind='a'/></mujoco>", r"MuJoCo can read; got .*bad.xml"),
        ("bad.urdf", "<robot><link", r"a URDF that can be read; got .*bad.urdf"),
        ("bad.urdf", "<mujoco/>", r"outermost element is <robot>; got .* with <mujoco>; name an"),
        (
            "bad.urdf", small_urdf().replace('child link="left_foot"', 'child link="lost"'),
            r"MuJoCo can read; got .*bad.urdf",
        ),
        (
            "bad.xml", paper_biped_mjcf(0.2, (0.2, 0.11)).replace('name="left_knee" ', ""),
            r"a name for every joint .* in 'left_shank' that has none",
        ),
        (
            "bad.xml", paper_biped_mjcf(0.2, (0.2, 0.11)).replace('mass="5.5"', 'mass="0"'),
            r"a model that MuJoCo can compile.*; repair the model",
        ),
    ],
)  # fmt: skip
def test_a_model_that_cannot_be_read(tmp_path: Path, name: str, text: str, message: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(sf.RobotError, match=message):
        load_multibody(paper_with(model=str(tmp_path / name)))


def test_a_point_mass_has_no_mechanism() -> None:
    with pytest.raises(sf.RobotError, match=r"\[body\] table.*'paper-table2', which is a point"):
        load_multibody(sf.load_robot("paper-table2"))


def test_a_model_that_weighs_something_else_is_refused(tmp_path: Path) -> None:
    path = write_small_biped(tmp_path)
    text = path.read_text()
    for mass, good in ((31.0, True), (28.6, True), (33.0, False), (20.0, False)):
        path.write_text(text.replace("mass = 30.0", f"mass = {mass}"))
        robot = sf.load_robot(path)
        assert load_multibody(robot, any_mass=True).mass == pytest.approx(30.0)
        if good:
            assert load_multibody(robot).mass == pytest.approx(30.0)
            continue
        with pytest.raises(sf.RobotError) as refusal:
            load_multibody(robot)
        for words in ("the mass of the model, 30 kg, to 5 %", f"mass = {mass:g}", "mass = 30, or"):
            assert words in str(refusal.value)
