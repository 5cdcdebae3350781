({
  /** Text whose contrast with the nearest plain color behind it is below WCAG AA. */
  contrasts() {
    const canvas = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const rgba = (color) => {
      canvas.clearRect(0, 0, 1, 1);
      canvas.fillStyle = color;
      canvas.fillRect(0, 0, 1, 1);
      return [...canvas.getImageData(0, 0, 1, 1).data];
    };
    const light = (color) => {
      const linear = color.map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
      return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
    };
    const behind = (element) => {
      for (let one = element; one; one = one.parentElement) {
        const color = rgba(getComputedStyle(one).backgroundColor);
        if (color[3] > 250) return color;
      }
      return [255, 255, 255, 255];
    };
    const bad = [];
    for (const one of document.querySelectorAll("body *")) {
      const told = [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
      if (!told || !seen(one) || one.closest(":disabled, .viewer, option, .skip")) continue;
      const pair = [light(rgba(getComputedStyle(one).color)), light(behind(one))];
      const ratio = (Math.max(...pair) + 0.05) / (Math.min(...pair) + 0.05);
      if (ratio < 4.5) bad.push(`${one.outerHTML.slice(0, 80)} ${ratio.toFixed(2)}`);
    }
    return bad;
    function seen(one) {
      const box = one.getBoundingClientRect();
      return box.width && box.height && getComputedStyle(one).visibility !== "hidden";
    }
  },

  /** Controls that say nothing to who cannot see them. */
  unnamed() {
    return [...document.querySelectorAll("button, input, select, a[href], [tabindex='0']")]
      .filter((one) => one.getClientRects().length)
      .filter((one) => !(one.getAttribute("aria-label") || one.labels?.length || one.textContent.trim() || one.title))
      .map((one) => one.outerHTML.slice(0, 120));
  },

  /** What reaches over the right border of the page, but for what is made to be scrolled. */
  wide() {
    return [...document.querySelectorAll("body *")]
      .filter((one) => one.getBoundingClientRect().width && one.getBoundingClientRect().right > innerWidth + 1)
      .filter((one) => !one.closest(".modes, .steps, .strip, pre, .views, table"))
      .map((one) => one.outerHTML.slice(0, 120));
  },

  /** The bytes of the hole that was painted, as they came to the server. */
  async painted() {
    const headers = {
      "X-Weftex-Token": sessionStorage.getItem("weftex-token"),
      "X-Weftex-Session": sessionStorage.getItem("weftex-session"),
    };
    const state = location.hash.split("state=")[1].replaceAll("-", "+").replaceAll("_", "/");
    const { mask: id } = JSON.parse(atob(state));
    const answer = await fetch(`/api/uploads/${id}`, { headers });
    return [...new Uint8Array(await answer.arrayBuffer())];
  },

  /** The name of the style of the line around what has the focus. */
  outline() {
    return getComputedStyle(document.activeElement).outlineStyle;
  },

  focus_is_lost() {
    return document.activeElement === document.body;
  },

  /** Labels of segmented choices with more than one line. */
  wrapped() {
    return [...document.querySelectorAll(".segment-row span")].filter((one) => one.offsetHeight > 40).map((one) => one.textContent);
  },

  focused() {
    return document.activeElement.textContent;
  },

  focused_value() {
    return document.activeElement.value;
  },
})
