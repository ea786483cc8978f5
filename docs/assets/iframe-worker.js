// The search runs in a worker, and browsers start no worker for a page that is opened from disk. There, the worker's script
// runs in a hidden frame, and messages arrive later, as from a worker. The name of this file keeps the plugin `offline` from loading a script of the same name from unpkg.com.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      this.waiting = [];
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      this.frame.title = "search";
      this.frame.answer = (data) => setTimeout(() => this.take("message", { data: structuredClone(data) }));
      this.frame.onload = () => {
        const waiting = this.waiting;
        this.waiting = null;
        waiting.forEach((data) => this.send(data));
      };
      const script = new URL(url, document.baseURI).href.replace(/"/g, "%22");
      this.frame.srcdoc =
        "<script>self.postMessage = (data) => frameElement.answer(data)</script>" + `<script src="${script}"></script>`;
      document.body.append(this.frame);
    }
    take(type, values) {
      const event = new MessageEvent(type, values);
      this["on" + type]?.(event);
      this.dispatchEvent(event);
    }
    send(data) {
      const inside = this.frame.contentWindow;
      setTimeout(() => inside.dispatchEvent(new inside.MessageEvent("message", { data: inside.structuredClone(data) })));
    }
    postMessage(data) {
      if (this.waiting) this.waiting.push(data);
      else this.send(data);
    }
    terminate() {
      this.frame.remove();
    }
  };
}
