"""A URDF as MuJoCo can read it: meshes found, links kept, limits that MuJoCo drops kept aside."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from surefoot.errors import RobotError

READABLE_MESHES = (".stl", ".obj", ".msh")
"""What MuJoCo reads; others (.dae) are left out of the picture."""

_MOST_FACES = 200_000
"""Of a mesh that MuJoCo accepts."""


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
    return path.stat().st_size == 84 + 50 * faces and 0 < faces <= _MOST_FACES
