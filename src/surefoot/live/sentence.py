"""The sentence at the head of a page, as HTML."""

from __future__ import annotations

import html

from surefoot.show import palette


def framed(words: str, fallen: bool = False, notice: str = "") -> str:
    """The sentence, large; red if it fell.

    Args:
        words: what happens.
        fallen: whether that is the end of it.
        notice: what could not be done; may be empty.
    """
    colour = palette.ALARM if fallen else palette.DCM
    more = f'<div style="color:#8a5a00;margin-top:6px">{html.escape(notice)}</div>'
    return (
        f'<div role="status" aria-live="polite" id="surefoot-sentence" '
        f'style="border-left:4px solid {colour};padding:6px 10px;margin:2px 8px 8px;'
        f'font-size:14px;line-height:1.4;min-height:4.2em">{html.escape(words)}'
        f"{more if notice else ''}</div>"
    )
