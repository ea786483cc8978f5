// The token of the run, without which the run sends no data. It comes with the fragment of the printed address, which browsers send to
// no server, and is kept for reloads of this tab. Cookies would reach all ports of the host.
// The rest of the fragment is a link to a graph, a node, a robot and a time.
const linked = new URLSearchParams(location.hash.slice(1));
if (linked.has("token")) {
  sessionStorage.setItem("token", linked.get("token"));
  linked.delete("token");
  history.replaceState(null, "", location.pathname + (linked.size ? `#${linked}` : ""));
}
addEventListener("hashchange", () => location.reload()); // the address of another run was opened in this tab

// The two connections of this tab, to the feed and to the 3D part, name the tab.
const tab = Math.random().toString(36).slice(2);

// Returns the address of a WebSocket of the run; null without a token.
function socketUrl(path) {
  const token = sessionStorage.getItem("token");
  return token && `${location.origin.replace("http", "ws")}/${path}?token=${encodeURIComponent(token)}&tab=${tab}`;
}
