"use strict";
document.documentElement.classList.add("scripted");
for (const slider of document.querySelectorAll("input[type=range]")) {
  const show = () => {
    slider.closest("figure").style.setProperty("--after", slider.value / 100);
    slider.setAttribute("aria-valuetext", `${100 - slider.value} % ${slider.dataset.before}, ${slider.value} % ${slider.dataset.after}`);
  };
  slider.addEventListener("input", show);
  show();
}
