// Contents from the headings, the switch between light and dark, and what the page holds packed.
const root = document.documentElement;

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// What a script of the page holds as base64 of gzip; the script is removed.
async function unpacked(id) {
  const script = document.getElementById(id);
  const letters = atob(script.textContent);
  script.remove();
  const bytes = new Uint8Array(letters.length);
  for (let at = 0; at < letters.length; at += 1) bytes[at] = letters.charCodeAt(at);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
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
