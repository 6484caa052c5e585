"""The documentation as a site: `sphinx-build -W -b html docs build/site`; pages are Markdown, read by MyST."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "site"))

import formulas  # noqa: E402
import pages  # noqa: E402

project = "mecano"
author = "mecano developers"
extensions = ["myst_parser"]
exclude_patterns = ["site"]
myst_heading_anchors = 3
myst_enable_extensions = ["deflist", "html_image"]  # <img> places pictures beside text on GitHub, too
myst_fence_as_directive = ["math"]  # as GitHub writes displayed formulas
smartquotes = False  # two apostrophes are a second derivative
highlight_language = "none"
man_pages = [("generated/commands", "mecano", "simulate flexible mechanisms", author, 1)]
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "mecano"
html_copy_source = False
html_use_index = False
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["site/static"]
html_css_files = ["site.css"]


def setup(app):
    """Register the rendering of formulas, and the pages generated from the code and the numbers of the tests."""
    app.add_html_math_renderer("mathml", (formulas.inline, None), (formulas.displayed, None))
    app.connect("builder-inited", lambda app: pages.write(HERE / "generated"))
