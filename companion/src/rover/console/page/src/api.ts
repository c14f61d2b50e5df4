// What goes to the console and comes from it.
export type Json = Record<string, any>;

export async function get(path: string): Promise<Json> {
  return answer(await fetch(`api/${path}`, { headers: { accept: "application/json" } }));
}

export async function post(path: string, content: Json = {}): Promise<Json> {
  return answer(await fetch(`api/${path}`, { method: "POST", body: JSON.stringify(content) }));
}

async function answer(response: Response): Promise<Json> {
  const told: Json = await response.json().catch(() => ({ ok: false, error: `HTTP ${response.status}` }));
  if (told.ok) return told;
  if (response.status === 401) location.reload();
  throw new Error(told.error ?? `HTTP ${response.status}`);
}

type Listener = (message: Json) => void;

/** The connection that is always open: to one run, or to the console alone. It comes back by itself. */
export class Live {
  private socket: WebSocket | null = null;
  private run = "";
  private wanted = false;
  private readonly listeners = new Map<string, Set<Listener>>();

  on(kind: string, listener: Listener): void {
    const known = this.listeners.get(kind) ?? new Set();
    this.listeners.set(kind, known.add(listener));
  }

  open(run: string): void {
    if (this.wanted && run === this.run) return;
    this.run = run;
    this.wanted = true;
    this.socket?.close();
    this.connect();
  }

  close(): void {
    this.wanted = false;
    this.socket?.close();
    this.socket = null;
  }

  /** True when it was handed to the network. */
  say(content: Json): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(content));
    return true;
  }

  private connect(): void {
    const address = new URL("api/live", document.baseURI);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    if (this.run) address.searchParams.set("run", this.run);
    const socket = new WebSocket(address);
    this.socket = socket;
    socket.onopen = () => this.tell({ kind: "open" });
    socket.onmessage = (event) => this.tell(JSON.parse(event.data));
    socket.onclose = () => {
      if (this.socket !== socket || !this.wanted) return;
      this.tell({ kind: "closed" });
      setTimeout(() => this.socket === socket && this.wanted && this.connect(), 1000);
    };
  }

  private tell(message: Json): void {
    for (const listener of this.listeners.get(message.kind) ?? []) listener(message);
  }
}
