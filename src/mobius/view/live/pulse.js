// Runs in the page before Studio's client. It tells the loop, 20 times a second and at every
// change, that this page is there, whether it has the focus, which drive keys are held and what a
// gamepad does. The client draws as fast as it can, which without a graphics card is about once a
// second and holds up the page meanwhile: the words are said by a worker, with the age of what
// the page last told it. A hidden page is silent, which counts as gone.
(() => {
  const KEYS = new Set(["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "KeyQ", "KeyE", "KeyR",
    "Space", "Digit1", "Digit2", "Digit3", "Digit4"]);
  if (new URLSearchParams(location.search).has("token"))
    history.replaceState(null, "", location.pathname);  // the cookie carries it from now on
  document.title = "mobius";

  const worker = new Worker(URL.createObjectURL(new Blob([`
    let socket = null, address = null, last = null, at = 0;
    const send = () => {
      if (last && !last.hidden && socket && socket.readyState === WebSocket.OPEN)
        socket.send(JSON.stringify({ ...last, age: (performance.now() - at) / 1000 }));
    };
    const connect = () => {
      const mine = new WebSocket(address);
      mine.onopen = send;
      mine.onclose = () => { if (socket === mine) setTimeout(connect, 300); };
      socket = mine;
    };
    onmessage = (e) => {
      if (e.data.address) {
        address = e.data.address;
        if (socket) { socket.onclose = null; socket.close(); }
        connect();
      } else {
        const changed = !last || e.data.keys.length !== last.keys.length;
        last = e.data;
        at = performance.now();
        if (changed) send();
      }
    };
    setInterval(send, 50);
  `], { type: "text/javascript" })));

  const held = new Set();
  const tell = () => {
    const pads = navigator.getGamepads ? [...navigator.getGamepads()] : [];
    const pad = pads.find((p) => p);
    worker.postMessage({
      hidden: document.hidden,
      focus: document.hasFocus(),
      keys: [...held],
      pad: pad ? { axes: [...pad.axes], buttons: pad.buttons.map((b) => +b.pressed) } : null,
    });
  };

  // Studio's client names its session in the address of its own socket: /ui?sid=...
  const Plain = window.WebSocket;
  let session = null;
  window.WebSocket = class extends Plain {
    constructor(address, protocols) {
      super(address, protocols);
      const url = new URL(address, location.href);
      if (url.pathname === "/ui" && url.searchParams.get("sid") !== session) {
        session = url.searchParams.get("sid");
        const scheme = location.protocol === "https:" ? "wss" : "ws";
        worker.postMessage({ address: `${scheme}://${location.host}/pulse?sid=${session}` });
      }
    }
  };

  window.addEventListener("keydown", (e) => {
    if (KEYS.has(e.code) && !e.ctrlKey && !e.altKey && !e.metaKey && !held.has(e.code)) {
      held.add(e.code);
      tell();
    }
  }, true);
  window.addEventListener("keyup", (e) => { if (held.delete(e.code)) tell(); }, true);
  const letGo = () => { held.clear(); tell(); };
  window.addEventListener("blur", letGo);
  window.addEventListener("focus", tell);
  document.addEventListener("visibilitychange", letGo);
  setInterval(tell, 50);
})();
