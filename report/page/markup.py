"""HTML from Python. Whatever comes from a record is text: nothing of it is ever markup."""

import base64
import html
import json
import math


class Markup(str):
    """Text that is HTML already."""


def escape(value):
    """Text as HTML; Markup stays as it is."""
    return value if isinstance(value, Markup) else Markup(html.escape(str(value), quote=True))


def tag(name, /, *content, **attributes):
    """<name attributes>content</name>; `class_` is class, `data_x` is data-x. True is an attribute without a value, None is none."""
    words = [name]
    for key, value in attributes.items():
        key = key.rstrip("_").replace("_", "-")
        if value is True:
            words.append(key)
        elif value is not None and value is not False:
            words.append(f'{key}="{escape(value)}"')
    return Markup(f"<{' '.join(words)}>{''.join(escape(each) for each in content)}</{name}>")


def void(name, /, **attributes):
    """An element without content, such as an image."""
    return Markup(tag(name, **attributes).removesuffix(f"</{name}>"))


def join(parts, between=""):
    return Markup(between.join(escape(each) for each in parts))


def json_block(name, value):
    """Data for the page's script. Nothing in it can end the block: < is written as an escape."""
    text = json.dumps(plain(value), ensure_ascii=True, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return Markup(f'<script type="application/json" id="{html.escape(name, quote=True)}">{text}</script>')


def plain(value):
    """With null for what is no finite number, and floats to nine digits."""
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return float(f"{value:.9g}") if math.isfinite(value) else None
    return value


def data_uri(kind, content):
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def script_text(text):
    """A script as it may stand between <script> and </script>."""
    return Markup(text.replace("</script", "<\\/script").replace("<!--", "<\\!--"))
