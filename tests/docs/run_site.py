#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Makes the site, in which every reference and every picture must lead to a file: doxygen warns of names that it does not know, but not of files.
Usage: run_site.py DOXYGEN DOXYFILE HTML_FOLDER
"""
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


doxygen, doxyfile, folder = sys.argv[1:]
code = subprocess.run([doxygen, doxyfile]).returncode
if code:
    sys.exit(code)
pages = sorted(pathlib.Path(folder).rglob("*.html"))
wrong = [f"{page.name}: no {target}" for page in pages for target in missing(page)]
print("\n".join(wrong) or f"{len(pages)} pages")
sys.exit(bool(wrong) or not pages)
