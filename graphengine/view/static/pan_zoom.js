// Zooming and moving of a drawing by its viewBox.
const SMALLEST = 0.5; // scale below which text is illegible; a larger drawing begins with its upper left part
const MOST = 1.25, FARTHEST = 8, STEP = 60;

export class PanZoom {
  constructor(area) {
    Object.assign(this, { area, x: 0, y: 0, scale: 1, width: 1, height: 1, picture: null });
    const fingers = new Map();
    area.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), event);
    }, { passive: false });
    area.addEventListener("pointerdown", (event) => {
      if (event.button === 0) fingers.set(event.pointerId, event);
      this.moved = false;
    });
    area.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const far = Math.hypot(event.clientX - last.clientX, event.clientY - last.clientY);
      if (!this.moved && far < 4) return; // a click
      if (!this.moved) area.setPointerCapture(event.pointerId);
      this.moved = true;
      const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
      if (other) {
        const distance = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY) || 1;
        this.zoom(distance(event) / distance(last), other);
      } else this.move((last.clientX - event.clientX) / this.scale, (last.clientY - event.clientY) / this.scale);
      fingers.set(event.pointerId, event);
    });
    for (const name of ["pointerup", "pointercancel"]) area.addEventListener(name, (event) => fingers.delete(event.pointerId));
    area.addEventListener("click", (event) => { if (this.moved) event.stopPropagation(); }, true); // a drag is no click
    area.addEventListener("keydown", (event) => {
      const keys = { "+": () => this.zoom(1.25), "=": () => this.zoom(1.25), "-": () => this.zoom(0.8), 0: () => this.fit(),
        ArrowLeft: () => this.move(-STEP, 0), ArrowRight: () => this.move(STEP, 0), ArrowUp: () => this.move(0, -STEP), ArrowDown: () => this.move(0, STEP) };
      if (event.ctrlKey || event.metaKey || event.altKey || !Object.hasOwn(keys, event.key)) return;
      event.preventDefault();
      event.stopPropagation();
      keys[event.key]();
    });
    new ResizeObserver(() => (this.fitted ? this.begin() : this.apply())).observe(area);
  }

  // Shows another drawing; the same one, drawn again, stays where it is.
  show(picture, same) {
    this.picture = picture;
    const { width, height } = picture.viewBox.baseVal;
    Object.assign(this, { width, height });
    if (same) this.apply();
    else this.begin();
  }

  begin() {
    this.fit();
    if (this.scale < SMALLEST) Object.assign(this, { scale: SMALLEST, x: 0, y: 0 });
    this.apply();
  }

  fit() {
    const { clientWidth, clientHeight } = this.area;
    this.scale = Math.min(clientWidth / this.width, clientHeight / this.height, MOST) || 1;
    this.x = (this.width - clientWidth / this.scale) / 2;
    this.y = Math.min(0, (this.height - clientHeight / this.scale) / 2);
    this.apply();
    this.fitted = true;
  }

  move(x, y) {
    this.x += x;
    this.y += y;
    this.apply();
    this.fitted = false;
  }

  zoom(factor, at) {
    const box = this.area.getBoundingClientRect(), scale = Math.min(Math.max(this.scale * factor, 0.02), FARTHEST);
    const [x, y] = at ? [at.clientX - box.left, at.clientY - box.top] : [box.width / 2, box.height / 2];
    this.move(x / this.scale - x / scale, y / this.scale - y / scale);
    this.scale = scale;
    this.apply();
  }

  // Moves the drawing so that an element is in sight.
  reveal(element) {
    const box = element.getBoundingClientRect(), room = this.area.getBoundingClientRect();
    if (box.left >= room.left && box.right <= room.right && box.top >= room.top && box.bottom <= room.bottom) return;
    this.move((box.left + box.width / 2 - room.left - room.width / 2) / this.scale, (box.top + box.height / 2 - room.top - room.height / 2) / this.scale);
  }

  apply() {
    const { clientWidth, clientHeight } = this.area;
    if (this.picture && clientWidth) this.picture.setAttribute("viewBox", [this.x, this.y, clientWidth / this.scale, clientHeight / this.scale].join(" "));
  }
}
