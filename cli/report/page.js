"use strict";
document.documentElement.classList.remove("no-script");

/* Wipe: the images of the sheet, two at a time. */
for (const scene of document.querySelectorAll("section.scene")) {
    const wipe = scene.querySelector(".wipe");
    const stage = wipe.querySelector(".stage");
    const [under, over] = [stage.querySelector(".under"), stage.querySelector(".over")];
    const [left, right] = wipe.querySelectorAll("select");
    const slider = stage.querySelector("input");
    const kinds = [...wipe.querySelectorAll(".kinds button")];
    let kind = "picture";

    const image = (entry, wanted) =>
        scene.querySelector(`img[data-entry="${entry}"][data-kind="${wanted}"]`);
    const show = () => {
        /* What an entry lacks (the truth has no error, a picture no visibility) is its picture. */
        const of = select => image(select.value, kind) || image(select.value, "picture");
        over.src = of(left).src;
        under.src = of(right).src;
        for (const button of kinds)
            button.setAttribute("aria-pressed", String(button.dataset.kind === kind));
    };
    const move = () => stage.style.setProperty("--at", `${slider.value}%`);
    slider.addEventListener("input", move);
    stage.addEventListener("pointermove", event => {
        if (event.pointerType === "mouse" && event.buttons === 0)
            return;
        const box = stage.getBoundingClientRect();
        slider.value = 100 * (event.clientX - box.left) / box.width;
        move();
    });
    scene.addEventListener("recolored", show);
    left.addEventListener("change", show);
    right.addEventListener("change", show);
    for (const button of kinds)
        button.addEventListener("click", () => {
            kind = button.dataset.kind;
            show();
        });
    show();
    move();
}

/* Error maps at another scale: their pixels are codes, 0 no figure, else 128 + 127 sign(e) sqrt(|e|),
 * coloured by the palette of the PNG, which follows its head. */
const ramp = JSON.parse(document.querySelector("#ramp").textContent);
const PALETTE = 33;

function checksum(bytes, from, to) {
    let value = 0xffffffff;
    for (let i = from; i < to; i++) {
        value ^= bytes[i];
        for (let k = 0; k < 8; k++)
            value = value >>> 1 ^ (value & 1 ? 0xedb88320 : 0);
    }
    return ~value >>> 0;
}

function recolor(source, scale) {
    const comma = source.indexOf(",");
    const bytes = Uint8Array.from(atob(source.slice(comma + 1)), letter => letter.charCodeAt(0));
    for (let code = 1; code < 256; code++) {
        const size = ((code - 128) / 127) ** 2 * Math.sign(code - 128);
        const at = Math.min(Math.max(0.5 + 0.5 * size / scale, 0), 1);
        bytes.set(ramp[Math.round(at * (ramp.length - 1))], PALETTE + 8 + 3 * code);
    }
    const end = PALETTE + 8 + 3 * 256;
    new DataView(bytes.buffer).setUint32(end, checksum(bytes, PALETTE + 4, end));
    let text = "";
    for (let i = 0; i < bytes.length; i += 8192)
        text += String.fromCharCode(...bytes.subarray(i, i + 8192));
    return source.slice(0, comma + 1) + btoa(text);
}

for (const select of document.querySelectorAll("select.scale"))
    select.addEventListener("change", () => {
        const scene = select.closest("section");
        for (const end of select.closest(".legend").querySelectorAll(".ramp b"))
            end.textContent = select.value;
        for (const map of scene.querySelectorAll('img[data-kind="error"]'))
            map.src = recolor(map.src, Number(select.value));
        scene.dispatchEvent(new Event("recolored"));
    });

/* Tables: a click on a head sorts by it, another turns the order round. */
for (const table of document.querySelectorAll("table.figures")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
        head.querySelector("button").addEventListener("click", () => {
            const ascending = head.getAttribute("aria-sort") !== "ascending";
            for (const other of heads)
                other.removeAttribute("aria-sort");
            head.setAttribute("aria-sort", ascending ? "ascending" : "descending");
            const key = row => {
                const text = row.cells[column].dataset.value;
                return text === undefined ? row.cells[column].textContent : Number(text);
            };
            const order = (a, b) => {
                const [x, y] = [key(a), key(b)];
                if (typeof x === "string")
                    return x.localeCompare(y, undefined, {numeric: true});
                /* Rows without the figure stay last. */
                if (Number.isNaN(x) || Number.isNaN(y))
                    return (Number.isNaN(x) - Number.isNaN(y)) * (ascending ? 1 : -1);
                return x - y;
            };
            const rows = [...table.tBodies[0].rows].sort((a, b) => (ascending ? 1 : -1) * order(a, b));
            table.tBodies[0].append(...rows);
        });
    });
}

/* The table of all scenes: another figure in its cells. */
for (const group of document.querySelectorAll(".kinds.matrix")) {
    const table = document.querySelector("table.matrix");
    const buttons = [...group.querySelectorAll("button")];
    const show = figure => {
        for (const cell of table.querySelectorAll("td[data-rmse]"))
            cell.textContent = cell.dataset[figure];
        for (const button of buttons)
            button.setAttribute("aria-pressed", String(button.dataset.figure === figure));
    };
    for (const button of buttons)
        button.addEventListener("click", () => show(button.dataset.figure));
    show("rmse");
}

/* Small pictures are the large ones again. */
for (const thumb of document.querySelectorAll("img[data-thumb]"))
    thumb.src = document.querySelector(
        `#${thumb.dataset.thumb} img[data-entry="truth"][data-kind="picture"]`).src;

/* Full size. */
const dialog = document.querySelector("dialog");
const large = dialog.querySelector("img");
dialog.addEventListener("click", () => dialog.close());
document.addEventListener("click", event => {
    const image = event.target.closest(".row img, .films img:not(.slice)");
    if (!image)
        return;
    large.src = image.src;
    large.alt = image.alt;
    dialog.showModal();
});
