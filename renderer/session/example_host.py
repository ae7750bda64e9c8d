#!/usr/bin/env python3
"""A host for `emberline session` that needs only Python's standard library. It opens a scene, orbits it once, prints
how soon each first picture arrived, and writes the last picture once that is finished. Its arguments are
SCENE OUT.pfm [EMBERLINE [WxH [SPP]]]."""
import array, json, math, mmap, subprocess, sys, time  # noqa: E401


class Session:
    def __init__(self, program="emberline", *options):
        self.process = subprocess.Popen([program, "session", *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.commands, self.segment, self.memory = 0, 0, None

    def send(self, do, **members):
        self.process.stdin.write(json.dumps({"do": do, **members}, allow_nan=False).encode() + b"\n")
        self.process.stdin.flush()

    def receive(self, wanted):
        """Returns the first message that is `wanted`, and skips the pictures that arrive before it."""
        while True:
            message = json.loads(self.process.stdout.readline() or '{"event": "error", "text": "emberline has ended"}')
            if message.get("event") == "picture":
                self.send("next", after=message["number"])
            if message.get("ok") is False or message.get("event") == "error":
                sys.exit(message.get("error") or message["text"])
            if wanted(message): return message  # noqa: E701

    def request(self, do, **members):
        self.commands += 1
        self.send(do, id=self.commands, **members)
        return self.receive(lambda m: m.get("id") == self.commands)

    def picture(self, good):
        """Returns the next picture that is `good`, and its bytes, valid until two more pictures are announced."""
        p = self.receive(lambda m: m.get("event") == "picture" and good(m))
        if p["segment"] != self.segment:
            with open(p["memory"], "rb") as file:
                self.segment, self.memory = p["segment"], mmap.mmap(file.fileno(), p["bytes"], access=mmap.ACCESS_READ)
        return p, memoryview(self.memory)[p["offset"]:p["offset"] + p["stride"] * p["height"]]


if __name__ == "__main__":
    scene, out, program, size, spp = (sys.argv[1:] + ["emberline", "640x360", "16"][len(sys.argv) - 3:])[:5]
    session, begun = Session(program, "--size", size, "--spp", spp, "--driver", "bisection"), time.perf_counter()
    view, now = session.request("open", scene=scene)["scene"]["view"], session.picture(lambda p: True)
    print(f"opened: {1000 * (time.perf_counter() - begun):.0f} ms")
    to, radius = view["look_at"], math.dist(view["look_from"], view["look_at"])
    for degrees in range(0, 360, 10):
        begun, angle = time.perf_counter(), math.radians(degrees)
        eye = [to[0] + radius * math.sin(angle), view["look_from"][1], to[2] + radius * math.cos(angle)]
        edit = session.request("camera", camera={**view, "look_from": eye, "up": [0, 1, 0]})["edit"]
        now = session.picture(lambda p: p["edit"] >= edit)
        print(f"{degrees} degrees: {1000 * (time.perf_counter() - begun):.1f} ms")
    p, pixels = now if now[0]["finished"] else session.picture(lambda p: p["finished"])
    with open(out, "wb") as file:  # PFM: rows from the bottom, R G B
        file.write(b"PF\n%d %d\n-1\n" % (p["width"], p["height"]))
        for row in reversed(range(p["height"])):
            rgba = array.array("f", pixels[row * p["stride"]:(row + 1) * p["stride"]].tobytes())
            file.write(array.array("f", [rgba[4 * i + k] for i in range(p["width"]) for k in range(3)]).tobytes())
    session.send("quit")
    sys.exit(session.process.wait())
