"""The joined styles and scripts: complete, lean, and named by their content."""

from __future__ import annotations

import re

import brotli
import pytest

from hmi.pages import bundle

UI = bundle.STATIC / "js" / "ui"


def test_every_script_and_style_is_in_exactly_one_file() -> None:
    listed = [name for parts in bundle.SCRIPTS.values() for name in parts]
    cameras = [f"camera/{path.stem}" for path in (bundle.STATIC / "js" / "camera").glob("*.js")]
    assert sorted(listed) == sorted([*cameras, *(path.stem for path in UI.glob("*.js"))])
    own = {"stop", "viser_frame"}  # STOP and the twin's frame bring their own
    styles = {path.stem for path in (bundle.STATIC / "css").glob("*.css")} - own
    of_screens = [part for name in bundle.SCREEN_STYLES for part in bundle.STYLE_PARTS.get(name, (name,))]
    assert sorted([*bundle.STYLES, *of_screens]) == sorted(styles)


def test_no_string_of_a_script_spans_lines() -> None:
    """Else dropping indents and comments would change what it says."""
    for path in [*UI.glob("*.js"), *(bundle.STATIC / "js" / "camera").glob("*.js")]:
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
            assert line.count("`") % 2 == 0, f"{path.name}:{number}"


def test_an_address_changes_with_the_content_and_names_an_existing_file() -> None:
    assert re.fullmatch(r"/static/js/boot\.js\?v=[0-9a-f]{12}", bundle.versioned("js/boot.js"))
    with pytest.raises(FileNotFoundError):
        bundle.versioned("js/none.js")


def test_fonts_in_the_style_sheet_carry_their_hashes_and_stay_on_our_origin() -> None:
    urls = re.findall(r"url\(([^)]+)\)", bundle.style_sheet().decode())
    assert len(urls) >= 3
    assert all(re.fullmatch(r"/static/[\w./-]+\?v=[0-9a-f]{12}", url) for url in urls)


def test_no_colour_stands_outside_the_tokens() -> None:
    for name in (*bundle.STYLES[1:], *bundle.SCREEN_STYLES):
        text = (bundle.STATIC / "css" / f"{name}.css").read_text("utf-8")
        assert re.findall(r"#[0-9a-fA-F]{3,8}\b(?![^{]*\{)", text) == [], name


def test_styles_and_scripts_of_a_cold_page_fit_their_share() -> None:
    """39 KB of the 400 KB that a cold page may cost until STOP is ready and the tiles show."""
    size = len(brotli.compress(bundle.script(), quality=9)) + len(brotli.compress(bundle.style_sheet(), quality=9))
    assert size < 39_400


def test_comments_stay_at_home_and_strings_stay_whole() -> None:
    text = """
      // a line of its own
      const far = "http://farm // field"; // why
      const near = `a // b`; // the robot's own
      go(); // 10 Hz
    """
    assert bundle._lean(text).splitlines() == [
        'const far = "http://farm // field";',
        "const near = `a // b`; // the robot's own",
        "go();",
    ]


def test_operating_texts_name_no_far_server() -> None:
    for text in (bundle.script().decode(), bundle.style_sheet().decode()):
        assert re.findall(r"https?://(?!www\.w3\.org)[\w.-]+", text) == []
