"use strict";
// Tables that buttons in their heads sort, and a slider through the increments of a case.
(() => {
  function sort(table, column, up) {
    const text = (row) => row.cells[column].textContent.replace(/\s/g, "");
    const order = (a, b) => parseFloat(text(a)) - parseFloat(text(b)) || text(a).localeCompare(text(b));
    const rows = [...table.tBodies[0].rows].sort((a, b) => (up ? order(a, b) : order(b, a)));
    table.tBodies[0].append(...rows);
  }

  for (const table of document.querySelectorAll("table.sorted")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
      const up = head.ariaSort !== "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      sort(table, column, up);
      });
    });
  }

  for (const section of document.querySelectorAll("section.case")) {
    const shots = [...section.querySelectorAll(".shots")], slider = section.querySelector(".slider input");
    const choice = section.querySelector("select[name=increment]");
    const show = () => {
      const name = shots[slider.value].dataset.increment;
      shots.forEach((shot) => { shot.hidden = shot.dataset.increment !== name; });
      slider.nextElementSibling.value = name;
      const option = choice && [...choice.options].find((one) => one.text === name);
      if (option && option.value !== choice.value) {
        choice.value = option.value;
        choice.dispatchEvent(new Event("input"));
      }
    };
    if (slider) {
      slider.addEventListener("input", show);
      show();
    }
  }
})();
