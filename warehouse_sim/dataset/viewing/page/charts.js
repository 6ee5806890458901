// Charts are plotted when they come into sight, in the colours of the page.

function layoutOf(layout = {}) {
  const probe = document.body.appendChild(element("i", { style: "color: var(--ink); background: var(--line)" }));
  const { color, backgroundColor: line } = getComputedStyle(probe);
  probe.remove();
  const axis = (given) => ({ gridcolor: line, zerolinecolor: line, automargin: true, ...given });
  return {
    height: 330, margin: { l: 56, r: 14, t: 12, b: 46 }, hovermode: "closest",
    paper_bgcolor: "transparent", plot_bgcolor: "transparent",
    font: { color, size: 12, family: getComputedStyle(document.body).fontFamily },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom" },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: line, activecolor: color },
    ...layout, xaxis: axis(layout.xaxis), yaxis: axis(layout.yaxis),
  };
}

const PLOT = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] };

// The library is large: it starts when the page is open and nothing else is to be done.
const SOON = { timeout: 500 };
const idle = new Promise((done) => addEventListener("load", () => requestIdleCallback(done, SOON)));
const library = idle.then(() => unpacked("plotly")).then((text) => {
  document.head.append(element("script", { textContent: text }));
});

function plot(place) {
  const source = place.querySelector("script");
  if (!source || !window.Plotly) return;
  const { data, layout } = JSON.parse(source.textContent);
  source.remove();
  place.given = layout;
  Plotly.newPlot(place, data, layoutOf(layout), PLOT);
}

const charts = document.querySelectorAll(".chart");
const sight = new IntersectionObserver((seen) => {
  for (const { isIntersecting, target } of seen) {
    if (isIntersecting) { sight.unobserve(target); requestIdleCallback(() => plot(target), SOON); }
  }
}, { rootMargin: "300px" });
library.then(() => charts.forEach((place) => sight.observe(place)));
const again = (size) => charts.forEach((place) => place.given && Plotly.relayout(place, { ...layoutOf(place.given), ...size }));
document.addEventListener("theme", () => again({}));

// Paper is light, and shows all charts, two side by side.
const PAPER = 470;
let shown;
addEventListener("beforeprint", () => {
  shown = root.dataset.theme;
  root.dataset.theme = "light";
  charts.forEach(plot);
  again({ width: PAPER });
});
addEventListener("afterprint", () => {
  if (shown) root.dataset.theme = shown;
  else delete root.dataset.theme;
  again({ width: null, autosize: true });
});
