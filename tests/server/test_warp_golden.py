"""The values that the page's own evaluation of a warp is compared with, in web/test/warp.test.ts."""

import runpy
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_page_is_tested_with_what_python_computes():
    made = runpy.run_path(str(ROOT / "tools" / "make_warp_golden.py"))
    kept = (ROOT / "web" / "test" / "warp_golden.json").read_text(encoding="utf-8")
    assert kept == made["golden"](), "run tools/make_warp_golden.py"
