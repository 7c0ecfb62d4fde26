"""Chromium without a window, to see pages as people do."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

NAMES = ("chromium", "chromium-browser", "google-chrome")

_QUIET = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--hide-scrollbars", "--enable-logging=stderr", "--virtual-time-budget=2000"),
)


@dataclass(frozen=True)
class Browser:
    """A Chromium, with a profile folder of its own."""

    program: str
    profile: Path

    def console(self, page: Path) -> list[str]:
        """What the browser's console says of a page: what it misses, and what it refused to load."""
        return re.findall(r"CONSOLE:\d+\] (.*)", self._run(page, "--dump-dom").stderr)

    def screenshot(self, page: Path, dark: bool = False, width: int = 1200) -> np.ndarray:
        """The page as a picture (h, w, 3) BGR."""
        out = self.profile / "page.png"
        scheme = f"--blink-settings=preferredColorScheme={0 if dark else 1}"
        self._run(page, scheme, f"--window-size={width},1600", f"--screenshot={out}")
        return np.asarray(cv2.imread(str(out)))

    def paper(self, page: Path) -> bytes:
        """The page as PDF."""
        out = self.profile / "page.pdf"
        self._run(page, "--no-pdf-header-footer", f"--print-to-pdf={out}")
        return out.read_bytes()

    def _run(self, page: Path, *options: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [
                self.program,
                *_QUIET,
                f"--user-data-dir={self.profile}",
                *options,
                page.resolve().as_uri(),
            ],
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
