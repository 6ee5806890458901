// Every table of a page: a click on a head sorts, a text and the choices above filter, a button saves it as CSV.
const valueOf = (cell) => cell?.dataset.value ?? cell?.textContent.trim() ?? "";

function compared(a, b) {
  const [x, y] = [parseFloat(a), parseFloat(b)];
  if (isNaN(x) || isNaN(y)) return isNaN(x) - isNaN(y) || a.localeCompare(b);
  return x - y;
}

function sorted(table, column, head) {
  const down = head.ariaSort !== "descending";
  for (const other of head.parentNode.cells) other.ariaSort = null;
  head.ariaSort = down ? "descending" : "ascending";
  const rows = [...table.tBodies[0].rows].sort((p, q) => {
    const [a, b] = [p, q].map((row) => valueOf(row.cells[column]));
    if (a === "" || b === "") return (a === "") - (b === ""); // what has no number stays below
    return down ? compared(b, a) : compared(a, b);
  });
  table.tBodies[0].append(...rows);
}

function csvOf(table) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const rows = [...table.rows];
  const intervals = [...rows[0].cells].map((_, at) => rows.some((row) => row.cells[at]?.dataset.low));
  return rows.map((row) => [...row.cells].flatMap((cell, at) => {
    const text = row === rows[0] ? cell.textContent.replace(/\s+/g, " ").trim() : valueOf(cell);
    const ends = row === rows[0] ? [`${text} low`, `${text} high`] : [cell.dataset.low ?? "", cell.dataset.high ?? ""];
    return [text, ...(intervals[at] ? ends : [])].map(quoted);
  }).join(",")).join("\n") + "\n";
}

function tools(table, number) {
  const heads = [...table.tHead.rows[0].cells];
  const bar = element("div", { className: "tools" });
  const tests = [];
  const filter = () => {
    for (const row of table.tBodies[0].rows) row.hidden = !tests.every((test) => test(row));
  };
  heads.forEach((head, at) => {
    if (!("choose" in head.dataset)) return;
    const names = [...new Set([...table.tBodies[0].rows].map((row) => valueOf(row.cells[at])))].filter(Boolean).sort();
    if (names.length < 2) return;
    const select = element("select", { onchange: filter, ariaLabel: head.textContent },
      new Option(`${head.textContent}: all`, ""), ...names.map((name) => new Option(name)));
    tests.push((row) => !select.value || valueOf(row.cells[at]) === select.value);
    bar.append(select);
  });
  if (table.tBodies[0].rows.length > 3) {
    const input = element("input", { type: "search", placeholder: "filter rows", oninput: filter, ariaLabel: "Filter" });
    tests.push((row) => row.textContent.toLowerCase().includes(input.value.toLowerCase()));
    bar.append(input);
  }
  const save = element("a", { className: "csv", textContent: "CSV", title: "Save the table as CSV" });
  save.download = `table-${number + 1}.csv`;
  save.href = `data:text/csv;charset=utf-8,${encodeURIComponent(csvOf(table))}`;
  bar.append(save);
  table.closest(".scroll").before(bar);
  heads.forEach((head, at) => {
    Object.assign(head, { tabIndex: 0, onclick: () => sorted(table, at, head) });
    head.onkeydown = (event) => event.key === "Enter" && sorted(table, at, head);
  });
}

document.querySelectorAll("main table").forEach(tools);
