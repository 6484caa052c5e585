"""Pages as a real browser leaves them."""

import shutil
import subprocess

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
OPTIONS = "--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-sync"
browser = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")


def dom(page):
    """The page as Chromium, without a network, leaves it."""
    command = [CHROMIUM, *OPTIONS.split(), f"--user-data-dir={page.parent / 'profile'}", "--window-size=1000,600"]
    ended = subprocess.run([*command, "--dump-dom", page.as_uri()], capture_output=True, text=True, timeout=120)
    return ended.stdout
