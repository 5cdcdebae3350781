"""The widget of notebooks in a real browser, with a model that stands in for the notebook's."""

from __future__ import annotations

import base64
from typing import Any

import pytest

import weftex
from weftex.studio.page_files import module, styles

MODEL = """async ([code, css, traits]) => {
  const heard = [];
  const model = {
    get: (name) => traits[name],
    on: (_, listener) => heard.push(listener),
    off: (_, listener) => heard.splice(heard.indexOf(listener), 1),
    send: async (content) => {
      const [told, buffers] = await window.ask(content);
      const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      const bytes = buffers.map((one) => new DataView(bytesOf(one).buffer));
      for (const listener of heard) listener(told, bytes);
    },
  };
  document.head.append(Object.assign(document.createElement("style"), { textContent: css }));
  const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
  const widget = (await import(url)).default;
  const el = document.body.appendChild(document.createElement("div"));
  window.end = await widget.render({ model, el });
}"""


@pytest.fixture
def shown(tab: Any) -> Any:
    """A page that shows a view, and what its console said."""
    pytest.importorskip("anywidget", reason="no anywidget: pip install 'weftex[notebook]'")

    def show(view: Any) -> Any:
        one = tab()
        said: list[Any] = []
        view.send = lambda content, buffers=None: said.append((content, buffers))

        def ask(content: dict[str, Any]) -> Any:
            view._answer(view, content, [])
            told, buffers = said.pop()
            return told, [base64.b64encode(part).decode() for part in buffers]

        one.page.expose_function("ask", ask)
        traits = {name: getattr(view, name) for name in ("_words", "_seen", "height")}
        one.page.evaluate(MODEL, [module(), styles(), traits])
        return one

    return show


def test_the_views_of_a_result(shown: Any) -> None:
    """Repeated, beside the sample, its maps, under the light, with what is laid over it."""
    made = weftex.synthesize("sample:stone_wall", 96, method="quilting", seed=1)
    one = shown(weftex.studio.view(made, height=360))
    page = one.page
    page.wait_for_selector(".weftex-view .about >> text=96 × 96")
    page.click("[data-key=repeat2]")
    for mode in ("split", "maps", "light", "picture"):
        page.click(f"[data-key={mode}]")
        page.wait_for_selector(f"[data-key={mode}][aria-pressed=true]")
    page.select_option(".notebook-foot select", "patches")
    page.hover(".viewer")
    page.wait_for_selector(".notebook-foot output >> text=Source pixel")
    assert "Position" in page.inner_text(".notebook-foot output")
    page.keyboard.press("r")
    assert one.faults == []
    page.evaluate("window.end()")
    assert page.query_selector(".viewer") is None
