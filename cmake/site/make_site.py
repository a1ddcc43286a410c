#!/usr/bin/env python3
"""The documentation as a small site: pages of HTML from the Markdown, with one navigation, readable offline.

    make_site.py ROOT OUT     reads ROOT/docs/README.md (the index: its headings and lists are the navigation) and every page that it or
                              another page links to; writes OUT/*.html, and the files that pages link to below OUT/files

OUT is a new or empty folder, or a site of before, which is taken away first. Exit codes: 0 done; 1 a relative link leads nowhere (each is
named; nothing is written); 2 OUT holds something else; 3 python3-markdown-it is missing. The same texts give the same bytes. Nothing is
loaded from anywhere else.
"""

import html
import os
import pathlib
import re
import shutil
import sys
import urllib.parse
from dataclasses import dataclass, field

HERE = pathlib.Path(__file__).resolve().parent
INDEX = "docs/README.md"
HOME = "README.md"
SIGN = ".palpate-site"  # what tells a site of ours from a folder of somebody's
MARKS = {"long": "takes minutes: the tests run it in their full mode", "part": "takes hours: the tests run the first case of each plan, in their full mode",
         "by": "run by the test {name}"}
IMAGES = (".png", ".svg", ".jpg", ".gif", ".mp4")


def anchor_of(title):
    """The anchor that GitHub gives a heading: words in small letters, joined by hyphens."""
    text = re.sub(r"[^\w\- ]", "", title.strip().lower())
    return text.replace(" ", "-")


def slug_of(path):
    """The name of a page's file: "docs/fit.md" -> "fit.html", "reference/PROTOCOL.md" -> "reference-protocol.html"."""
    if path == HOME:
        return "index.html"
    name = path.removeprefix("docs/").removesuffix(".md")
    return ("docs" if name == "README" else name.replace("/", "-").lower()) + ".html"


@dataclass
class Page:
    path: str  # relative to the root, with slashes
    tokens: list
    title: str
    anchors: set = field(default_factory=set)


def markdown():
    from markdown_it import MarkdownIt  # python3-markdown-it
    return MarkdownIt("commonmark", {"html": False}).enable(["table", "strikethrough"])


def inline_text(token):
    return "".join(child.content for child in token.children or [] if child.type in ("text", "code_inline"))


def read_page(root, path, parser):
    """A page with the anchors of its headings set. Headings of one name are counted on, as GitHub does."""
    tokens = parser.parse((root / path).read_text(encoding="utf-8"))
    page, seen = Page(path, tokens, path), {}
    for token, text in zip(tokens, tokens[1:]):
        if token.type != "heading_open":
            continue
        title = inline_text(text)
        base = anchor_of(title)
        anchor = base if base not in seen else f"{base}-{seen[base]}"
        seen[base] = seen.get(base, 0) + 1
        token.attrSet("id", anchor)
        page.anchors.add(anchor)
        if token.tag == "h1" and page.title == path:
            page.title = title
    return page


def links_of(page):
    """(token, attribute) of every link and picture."""
    for token in page.tokens:
        for child in token.children or []:
            if child.type in ("link_open", "image"):
                yield child, "href" if child.type == "link_open" else "src"


def target_of(page, address):
    """(path from the root, anchor) of a relative address; None for one that leads outside (https:, mailto:)."""
    parts = urllib.parse.urlsplit(address)
    if parts.scheme or parts.netloc:
        return None
    path = urllib.parse.unquote(parts.path)
    place = os.path.normpath(os.path.join(os.path.dirname(page.path), path)) if path else page.path
    return pathlib.PurePath(place).as_posix(), parts.fragment


def read_pages(root, parser):
    """The index and every page of Markdown that can be reached from it."""
    pages, waiting = {}, [HOME, INDEX]
    while waiting:
        path = waiting.pop(0)
        if path in pages:
            continue
        pages[path] = read_page(root, path, parser)
        for token, name in links_of(pages[path]):
            found = target_of(pages[path], token.attrGet(name))
            if found and found[0].endswith(".md") and (root / found[0]).is_file():
                waiting.append(found[0])
    return pages


def broken_links(root, pages):
    """What leads nowhere, as texts."""
    for page in pages.values():
        for token, name in links_of(page):
            address = token.attrGet(name)
            found = target_of(page, address)
            if found is None:
                continue
            path, anchor = found
            if path.startswith("..") or not (root / path).exists():
                yield f"{page.path}: no file {address}"
            elif anchor and path in pages and anchor not in pages[path].anchors:
                yield f"{page.path}: no heading {address}"


# --- Writing ----------------------------------------------------------------------------------------------------------------


def file_address(path):
    return "files/" + urllib.parse.quote(path)


def relink(root, page, pages):
    """Turns the links of a page to those of the site; returns the files and folders that they lead to."""
    files = set()
    for token, name in links_of(page):
        found = target_of(page, token.attrGet(name))
        if found is None:
            continue
        path, anchor = found
        if path in pages:
            address = slug_of(path) + (f"#{anchor}" if anchor else "")
        elif (root / path).is_dir():
            inside = next((f"{path}/{each}" for each in ("README.md",) if f"{path}/{each}" in pages), None)
            address = slug_of(inside) if inside else file_address(path) + "/index.html"
            files |= set() if inside else {path}
        else:
            address = file_address(path)
            files.add(path)
        token.attrSet(name, address)
    return files


def mark_blocks(page):
    """Says at a block of commands that the tests do not run it each time."""
    from markdown_it.token import Token
    out = []
    for token in page.tokens:
        out.append(token)
        words = token.info.split() if token.type == "fence" else []
        if len(words) > 1 and words[1] in MARKS:
            out.append(Token("html_block", "", 0, content=f'<p class="mark">{html.escape(MARKS[words[1]].format(name=" ".join(words[2:])))}</p>\n'))
    page.tokens = out


def navigation(pages, current):
    """The index's headings and lists, as the side of each page."""
    parts = [f'<a class="home" href="index.html">Palpate</a>']
    in_item = False
    for token in pages[INDEX].tokens:
        if token.type == "inline" and token.level == 1 and not in_item and parts_heading(token, pages):
            parts.append(f"<h2>{html.escape(inline_text(token))}</h2>")
        in_item = token.type == "list_item_open" or (in_item and token.type != "list_item_close")
        if token.type == "inline" and in_item:
            link = next((child for child in token.children if child.type == "link_open"), None)
            found = link and target_of(pages[INDEX], link.meta.get("was", link.attrGet("href")))
            if found and found[0] in pages:
                here = ' aria-current="page"' if found[0] == current.path else ""
                parts.append(f'<a href="{slug_of(found[0])}"{here}>{html.escape(link_text(token, link))}</a>')
    return "\n".join(parts)


def parts_heading(token, pages):
    """Whether an inline text is that of a second heading of the index."""
    tokens = pages[INDEX].tokens
    place = next(i for i, each in enumerate(tokens) if each is token)
    return tokens[place - 1].type == "heading_open" and tokens[place - 1].tag == "h2"


def link_text(token, link):
    text, children = "", token.children
    for child in children[children.index(link) + 1:]:
        if child.type == "link_close":
            break
        text += child.content
    return text


def contents(page):
    """The second headings of a long page, as links."""
    found = [(token.attrGet("id"), inline_text(text)) for token, text in zip(page.tokens, page.tokens[1:])
             if token.type == "heading_open" and token.tag == "h2"]
    if len(found) < 4:
        return ""
    links = "".join(f'<li><a href="#{anchor}">{html.escape(title)}</a></li>' for anchor, title in found)
    return f'<nav class="contents" aria-label="On this page"><ul>{links}</ul></nav>'


def page_html(page, pages, parser, style):
    body = parser.renderer.render(page.tokens, parser.options, {})
    body = body.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")
    head, rest = (body[:body.index("</h1>") + 5], body[body.index("</h1>") + 5:]) if "</h1>" in body else ("", body)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(page.title)}{"" if page.path == HOME else " - Palpate"}</title>
<style>
{style}</style>
</head>
<body>
<a class="skip" href="#text">To the text</a>
<nav class="side" aria-label="Pages">
{navigation(pages, page)}
</nav>
<main id="text">
{head}
{contents(page)}
{rest}</main>
</body>
</html>
"""


def listing_html(path, names, style):
    """A page for a folder that a page links to."""
    items = "".join(f'<li><a href="{urllib.parse.quote(name)}">{html.escape(name)}</a></li>' for name in names)
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(path)}</title><style>\n{style}</style></head>'
            f'<body><main id="text"><h1>{html.escape(path)}</h1><ul>{items}</ul></main></body></html>\n')


def copy_files(root, files, out, style):
    for path in sorted(files):
        source, place = root / path, out / "files" / path
        if source.is_dir():
            names = sorted(each.name for each in source.iterdir() if each.is_file())
            place.mkdir(parents=True, exist_ok=True)
            for name in names:
                shutil.copyfile(source / name, place / name)
            (place / "index.html").write_text(listing_html(path, names, style), encoding="utf-8")
        else:
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, place)


def make_site(root, out):
    """Writes the site; returns what is wrong with the links (then nothing is written)."""
    parser = markdown()
    pages = read_pages(root, parser)
    wrong = list(broken_links(root, pages))
    if wrong:
        return wrong
    style = (HERE / "style.css").read_text(encoding="utf-8")
    for token, name in links_of(pages[INDEX]):
        token.meta["was"] = token.attrGet(name)
    files = set()
    for page in pages.values():
        files |= relink(root, page, pages)
        mark_blocks(page)
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    (out / SIGN).write_text("", encoding="utf-8")
    for page in pages.values():
        (out / slug_of(page.path)).write_text(page_html(page, pages, parser, style), encoding="utf-8")
    copy_files(root, files, out, style)
    return []


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    root, out = map(pathlib.Path, sys.argv[1:])
    if out.exists() and not (out.is_dir() and ((out / SIGN).exists() or not any(out.iterdir()))):
        print(f"site: expected a new or empty folder or a site of before, found {out}", file=sys.stderr)
        return 2
    try:
        wrong = make_site(root, out)
    except ImportError as error:
        print(f"site: {error} (packages.txt: python3-markdown-it)", file=sys.stderr)
        return 3
    for line in wrong:
        print(f"site: {line}", file=sys.stderr)
    if not wrong:
        print(f"Written: {out / 'index.html'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
