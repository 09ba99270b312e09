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

/* Error maps at another scale: colours anew from the errors themselves, kept as grey codes: 0 no
 * figure, else 128 + 127 sign(e) sqrt(|e|). */
const ramp = JSON.parse(document.querySelector("#ramp").textContent);

function recolor(codes, width, height, scale) {
    const canvas = document.createElement("canvas");
    canvas.width = width;
    canvas.height = height;
    const drawing = canvas.getContext("2d", {willReadFrequently: true});
    drawing.drawImage(codes, 0, 0);
    const pixels = drawing.getImageData(0, 0, width, height);
    const colors = Array.from({length: 256}, (_, code) => {
        if (code === 0)
            return [68, 68, 68];
        const size = ((code - 128) / 127) ** 2 * Math.sign(code - 128);
        const at = Math.min(Math.max(0.5 + 0.5 * size / scale, 0), 1);
        return ramp[Math.round(at * (ramp.length - 1))];
    });
    for (let i = 0; i < pixels.data.length; i += 4) {
        const color = colors[pixels.data[i]];
        pixels.data[i] = color[0];
        pixels.data[i + 1] = color[1];
        pixels.data[i + 2] = color[2];
    }
    drawing.putImageData(pixels, 0, 0);
    return canvas.toDataURL();
}

for (const select of document.querySelectorAll("select.scale"))
    select.addEventListener("change", async () => {
        const scene = select.closest("section");
        for (const end of select.closest(".legend").querySelectorAll(".ramp b"))
            end.textContent = select.value;
        for (const map of scene.querySelectorAll("img[data-codes]")) {
            const codes = new Image();
            codes.src = map.dataset.codes;
            await codes.decode();
            map.src = recolor(codes, codes.naturalWidth, codes.naturalHeight, Number(select.value));
        }
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

/* Full size. */
const dialog = document.querySelector("dialog");
const large = dialog.querySelector("img");
dialog.addEventListener("click", () => dialog.close());
document.addEventListener("click", event => {
    const image = event.target.closest(".row img");
    if (!image)
        return;
    large.src = image.src;
    large.alt = image.alt;
    dialog.showModal();
});
