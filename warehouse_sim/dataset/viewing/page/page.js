// Contents from the headings, and the switch between light and dark.
const root = document.documentElement;

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

const contents = document.getElementById("contents");
for (const head of document.querySelectorAll("main h2[id]")) {
  contents.append(element("a", { href: `#${head.id}`, textContent: head.textContent }));
  head.append(element("a", { className: "anchor", href: `#${head.id}`, textContent: "#", ariaLabel: "Link to here" }));
}

document.getElementById("theme").onclick = () => {
  const dark = getComputedStyle(root).getPropertyValue("color-scheme").trim() === "dark"
    || (!root.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches);
  root.dataset.theme = dark ? "light" : "dark";
  document.dispatchEvent(new Event("theme"));
};
