"""viser's client as installed: every injection finds what it was made for, so that another viser is noticed here."""

from __future__ import annotations

import gzip
import re
from importlib.metadata import version

import pytest

from hmi.app.viser_page import ViserChanged, client_file, patched, viser_page
from hmi.pages import bundle

FRAME = (bundle.STATIC / "js/viser_frame.js").read_text("utf-8")
SOURCE = client_file().parents[1] / "src"


def said(name: str) -> str:
    """Return a source file of viser's client."""
    return (SOURCE / name).read_text("utf-8")


def test_the_version_is_the_one_the_injections_were_made_for() -> None:
    assert version("viser") == "1.1.1"


def test_our_script_comes_before_viser_and_both_stand_in_the_head() -> None:
    html = viser_page().html.decode()
    assert re.search(r"viser_frame\.js\?v=.*/viser/client\.js\?v=.*</head>", html, re.DOTALL)
    assert html.count("<script") == 2
    assert len(html) < 10_000, "the code stays outside, where browsers keep it"


def test_the_code_is_whole_and_packed_once() -> None:
    page = viser_page()
    assert gzip.decompress(page.code_packed) == page.code
    assert len(page.code) > 700_000


@pytest.mark.parametrize(
    "text", ["", "<html><head></head></html>", '<script src="/assets/index.js"></script></head>'], ids=range(3)
)
def test_another_client_is_refused(text: str) -> None:
    with pytest.raises(ViserChanged):
        patched(text)


def test_1_reconnecting_asks_for_the_focus_which_we_grant() -> None:
    assert "!isConnected && document.hasFocus()" in said("WebsocketInterface.tsx")
    assert "document.hasFocus = () => true" in FRAME


def test_2_the_worker_says_connected_closed_and_batches_and_takes_its_server() -> None:
    worker = said("WebsocketClientWorker.ts")
    for kind in ('"connected"', '"closed"', '"message_batch"', '"set_server"', '"retry"'):
        assert f"type: {kind}" in worker
        assert kind in FRAME


def test_2_a_batch_brings_the_messages_by_which_the_robot_is_known_to_have_come() -> None:
    assert 'postOutgoing({ type: "message_batch", messages: messages }' in said("WebsocketClientWorker.ts")
    for kind in ("FrameMessage", "GlbMessage"):
        assert f'type: "{kind}"' in said("WebsocketMessages.ts")
        assert f'"{kind}"' in FRAME


def test_3_the_panel_and_the_notices_have_the_names_that_are_hidden() -> None:
    style = (bundle.STATIC / "css/viser_frame.css").read_text("utf-8")
    assert "data-floating-window={win.id}" in said("dock/FloatingWindowView.tsx")
    assert "@mantine/notifications" in said("App.tsx")
    for name in ("[data-floating-window]", "[data-dock-region]", ".mantine-Notifications-root", ".mantine-Paper-root"):
        assert name in style


def test_4_taps_are_judged_on_the_canvas_and_touch_capture_is_let_go() -> None:
    assert "onPointerUp" in said("App.tsx")
    assert "releasePointerCapture(event.pointerId)" in FRAME


def test_5_a_public_tunnel_is_asked_for_by_the_names_we_drop() -> None:
    assert 'type: "ShareUrlRequest"' in said("ControlPanel/ControlPanel.tsx")
    assert "^ShareUrl" in FRAME


def test_6_the_loader_makes_a_script_that_gets_the_nonce() -> None:
    assert b'document.createElement("script")' in viser_page().code
    assert "node.nonce = nonce" in FRAME


def test_7_the_keys_of_stop_are_those_of_the_page_around() -> None:
    slab = (bundle.STATIC / "js/stop.js").read_text("utf-8")
    keys = 'event.key === "Pause" || event.code === "Pause" || (event.ctrlKey && (event.key === "." || event.code ==='
    assert keys in slab
    assert keys in FRAME
