"""A picture into a file; the same picture gives the same bytes."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

from matplotlib import style
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke

from surefoot.checks import check_writable
from surefoot.errors import FileError
from surefoot.show import palette
from surefoot.version import VERSION

FORMATS = (".png", ".pdf", ".svg")
"""The endings that a picture's file may have."""

DPI = 160
"""Of a .png [1/in]."""

HALO = [withStroke(linewidth=2.2, foreground="white")]
"""Path effects that keep a text readable on lines and areas."""


def picture_bytes(figure: Figure, form: str, title: str = "", description: str = "") -> bytes:
    """A picture as the content of a file.

    Args:
        figure: the picture.
        form: "png", "pdf" or "svg".
        title: of the file.
        description: what else the file says about the picture.
    """
    maker = f"Surefoot {VERSION}"
    about: dict[str, str | None] = {"Title": title}
    if description:
        about["Subject" if form == "pdf" else "Description"] = description
    if form == "png":
        about["Software"] = maker
    elif form == "pdf":
        about |= {"Creator": maker, "Producer": maker, "CreationDate": None}
    else:
        about |= {"Creator": maker, "Date": None}
    stream = BytesIO()
    with style.context(["default", palette.STYLE]):
        figure.savefig(stream, format=form, dpi=DPI, metadata=about)
    return stream.getvalue()


def marker_path(how: palette.Mark) -> Outline:
    """The marker of a method as matplotlib wants it."""
    return Outline([*how.outline, how.outline[0]], closed=True)


def write_picture(figure: Figure, path: Path, title: str = "", description: str = "") -> None:
    """Write a picture; the ending of the path names the format, see `picture_bytes`.

    Raises:
        FileError: the file cannot be written.
    """
    content = picture_bytes(figure, path.suffix.lower()[1:], title, description)
    try:
        path.write_bytes(content)
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error.strerror}", "choose another place"
        ) from error


def draw_picture(
    make: Callable[[], Figure], path: Path, title: str = "", description: str = ""
) -> None:
    """Make a picture in the house's style, and write it; see `picture_bytes`.

    Args:
        make: the picture.
        path: file to write; its ending names the format (.png, .pdf, .svg).
        title: of the file.
        description: what else the file says about the picture.

    Raises:
        FileError: another ending, or the file cannot be written.
    """
    check_writable(path, FORMATS)
    with style.context(["default", palette.STYLE]):
        figure = make()
    write_picture(figure, path, title, description)
