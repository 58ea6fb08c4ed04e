#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Makes the site. In it every reference and every picture must lead to a file, and every heading of our own pages must stand.
Doxygen warns of names that it does not know, but not of files, nor of pages that its filter loses.
Usage: run_site.py DOXYGEN DOXYFILE HTML_FOLDER
"""
import html
import pathlib
import re
import subprocess
import sys
import urllib.parse


def missing(page):
    """References of a page to files that are not there; those to other sites are left alone."""
    for target in re.findall(r'\b(?:src|href)="([^"]*)"', page.read_text(errors="replace")):
        path = urllib.parse.unquote(urllib.parse.urlsplit(target).path)
        if path and not urllib.parse.urlsplit(target).scheme and not (page.parent / path).exists():
            yield target


def lost_headings(pages):
    """Of the pages on paper, those that no page of the site has."""
    source = pathlib.Path(__file__).resolve().parents[2]
    words = html.unescape(re.sub(r"<[^>]*>", "", " ".join(page.read_text(errors="replace") for page in pages)))
    for paper in [source / "README.md", source / "ARCHITECTURE.md", *sorted((source / "docs").glob("*.md"))]:
        for heading in re.findall(r"^##+ (.+)$", re.sub(r"^```.*?^```", "", paper.read_text(), flags=re.M | re.S), flags=re.M):
            if re.sub(r"[`*]", "", heading) not in words:
                yield f"{paper.name}: {heading}"


doxygen, doxyfile, folder = sys.argv[1:]
code = subprocess.run([doxygen, doxyfile]).returncode
if code:
    sys.exit(code)
pages = sorted(pathlib.Path(folder).rglob("*.html"))
wrong = [f"{page.name}: no {target}" for page in pages for target in missing(page)]
wrong += [f"lost: {heading}" for heading in lost_headings(page for page in pages if page.name.startswith(("md_", "index")))]
print("\n".join(wrong) or f"{len(pages)} pages")
sys.exit(bool(wrong) or not pages)
