"use strict";
// Values under the pointer: the closest point of the panel that the pointer is in. Everything is unfolded for printing.
(function () {
  const REACH = 24; // how far from the pointer a point may be, in points of the figure

  function closest(panel, x, y) {
    let best = null, far = REACH * REACH;
    for (const line of panel.lines) for (const [px, py, u, v] of line.points) {
      const d = (px - x) ** 2 + (py - y) ** 2;
      if (d < far) { far = d; best = { line, px, py, u, v }; }
    }
    return best;
  }

  function make(parent, kind) {
    const made = document.createElement("div");
    made.className = kind;
    made.hidden = true;
    parent.appendChild(made);
    return made;
  }

  document.querySelectorAll(".plot").forEach((plot) => {
    const panels = JSON.parse(plot.querySelector("script").textContent), [width, height] = plot.dataset.size.split(" ").map(Number);
    const tip = make(plot, "tip"), dot = make(plot, "dot");
    const hide = () => { tip.hidden = dot.hidden = true; };
    plot.addEventListener("pointerleave", hide);
    plot.addEventListener("pointermove", (event) => {
      const frame = plot.getBoundingClientRect(), scale = frame.width / width;
      const x = (event.clientX - frame.left) / scale, y = ((event.clientY - frame.top) * height) / frame.height;
      const panel = panels.find(({ box }) => box[0] <= x && x <= box[2] && box[1] <= y && y <= box[3]);
      const found = panel && closest(panel, x, y);
      if (!found) return hide();
      tip.hidden = dot.hidden = false;
      tip.textContent = [panel.title, found.line.name].filter(Boolean).join(", ") + (panel.title || found.line.name ? ": " : "") + found.u + ", " + found.v;
      dot.style.background = found.line.colour;
      dot.style.left = found.px * scale + "px";
      dot.style.top = found.py * scale + "px";
      const left = Math.min(found.px * scale + 10, frame.width - tip.offsetWidth - 2);
      tip.style.left = Math.max(2, left) + "px";
      tip.style.top = Math.max(2, found.py * scale - 30) + "px";
    });
  });

  let folded = [];
  window.addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    folded.forEach((each) => { each.open = true; });
  });
  window.addEventListener("afterprint", () => folded.forEach((each) => { each.open = false; }));
})();
