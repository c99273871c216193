"""Puts OpenColorIO's headers and library into DIR/ocio, from its release on the package index.
The wheel holds a self-contained libOpenColorIO.so, the source archive its headers; nothing is
compiled."""

import base64
import hashlib
import html.parser
import json
import os
import pathlib
import platform
import shlex
import shutil
import ssl
import subprocess
import sys
import tarfile
import time
import urllib.error
import urllib.parse
import urllib.request
import zipfile

VERSION = "2.6.0"
SDIST = (
    f"opencolorio-{VERSION}.tar.gz",
    "b124f4573e425e17764e64d1fdac51a956e066b905c8a7f8712410b3103d2ef0",
)
WHEEL = (
    f"opencolorio-{VERSION}-cp311-cp311-manylinux_2_27_x86_64.manylinux_2_28_x86_64.whl",
    "3df85517096baac44a8d67b6c9514c8b26ad8232ca0d2a3216e405f146da7cf9",
)
JSON_TYPE = "application/vnd.pypi.simple.v1+json"
SECTIONS = ("global", "download", "install", ":env:")  # later ones win, as in pip


def pip_config():
    """pip's settings by name, each a list of words."""
    out = subprocess.run(
        [sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True, check=False
    ).stdout
    found = {}
    for line in out.splitlines():
        key, _, value = line.partition("=")
        section, _, name = key.rpartition(".")
        if section in SECTIONS:
            words = shlex.split(value)[0].replace("\\n", " ").split() if value else []
            rank = SECTIONS.index(section)
            if rank >= found.get(name, (-1,))[0]:
                found[name] = rank, words
    return {name: words for name, (_, words) in found.items()}


class Links(html.parser.HTMLParser):
    """The anchors of an HTML index page: file name -> address."""

    def __init__(self):
        super().__init__()
        self.found, self.href = {}, None

    def handle_starttag(self, tag, attrs):
        if tag == "a":
            self.href = dict(attrs).get("href")

    def handle_data(self, data):
        if self.href:
            self.found[data.strip()] = self.href

    def handle_endtag(self, tag):
        self.href = None


class Index:
    """Reads pages and files as pip is set up to: indexes, certificates, proxy, trusted hosts."""

    def __init__(self, config):
        one = config.get("index-url") or ["https://pypi.org/simple"]
        self.roots = (
            []
            if config.get("no-index", ["0"])[0] in ("1", "true", "yes", "on")
            else one + config.get("extra-index-url", [])
        )
        self.folders = config.get("find-links", [])
        self.trusted = config.get("trusted-host", [])
        self.context = ssl.create_default_context(cafile=(config.get("cert") or [None])[0])
        self.proxy = (config.get("proxy") or [None])[0]

    def open(self, url, accept="*/*"):
        parts = urllib.parse.urlsplit(url)
        request = urllib.request.Request(url, headers={"Accept": accept})
        context = self.context
        if parts.username:  # urllib does not take user:password@ by itself
            secret = urllib.parse.unquote(f"{parts.username}:{parts.password or ''}")
            bare = parts._replace(netloc=parts.netloc.rpartition("@")[2])
            request = urllib.request.Request(
                urllib.parse.urlunsplit(bare),
                headers={
                    "Accept": accept,
                    "Authorization": "Basic " + base64.b64encode(secret.encode()).decode(),
                },
            )
        if parts.hostname in self.trusted or f"{parts.hostname}:{parts.port}" in self.trusted:
            context = ssl._create_unverified_context()
        handlers = [urllib.request.HTTPSHandler(context=context)]
        if self.proxy:
            handlers.append(urllib.request.ProxyHandler({"http": self.proxy, "https": self.proxy}))
        return urllib.request.build_opener(*handlers).open(request, timeout=60)

    def page(self, root):
        """Address of every file on the project's page under an index's root."""
        url = root.rstrip("/") + "/opencolorio/"
        if url.startswith("file:"):
            url += "index.html"
        with self.open(url, accept=f"{JSON_TYPE}, text/html;q=0.5") as answer:
            text, base = answer.read().decode(), answer.geturl()
            if "json" in answer.headers.get("Content-Type", ""):
                links = {f["filename"]: f["url"] for f in json.loads(text)["files"]}
            else:
                parser = Links()
                parser.feed(text)
                links = parser.found
        return {name: urllib.parse.urljoin(base, link) for name, link in links.items()}

    def fetch(self, name, sha256, cache):
        """The file's path in `cache`, downloaded if need be. Its hash is checked either way."""
        path = cache / name
        if path.exists() and digest(path) == sha256:
            return path
        reasons = []
        for folder in self.folders:
            local = pathlib.Path(folder.removeprefix("file://")) / name
            if local.exists() and digest(local) == sha256:
                return local
        for root in self.roots:
            try:
                self.download(self.page(root)[name], path)
                if digest(path) == sha256:
                    return path
                reasons.append("another sha256 than pinned")
            except KeyError:
                reasons.append("not on the project's page")
            except (OSError, ValueError) as error:
                reasons.append(str(getattr(error, "reason", error)))
        why = "; ".join(reasons) or "no index"
        sys.exit(f"dependencies: cannot get {name} from pip's package index: {why}")

    def download(self, url, path):
        part = path.with_suffix(".part")
        for attempt in range(3):
            try:
                with self.open(url) as answer, open(part, "wb") as out:
                    shutil.copyfileobj(answer, out)
                break
            except (urllib.error.URLError, OSError):
                if attempt == 2:
                    raise
                time.sleep(2)
        part.replace(path)


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def abi_header(template):
    """OpenColorABI.h from its template, as OpenColorIO's own build would fill it in."""
    major, minor, patch = VERSION.split(".")
    values = {
        "OpenColorIO_VERSION": VERSION,
        "OpenColorIO_VERSION_RELEASE_TYPE": "",
        "OpenColorIO_VERSION_MAJOR": major,
        "OpenColorIO_VERSION_MINOR": minor,
        "OpenColorIO_VERSION_PATCH": patch,
        "OCIO_NAMESPACE": f"OpenColorIO_v{major}_{minor}",  # as the wheel was built
        "PROJECT_NAME": "OpenColorIO",
    }
    for name, value in values.items():
        template = template.replace(f"@{name}@", value)
    if "@" in template:
        sys.exit("dependencies: OpenColorABI.h.in has a placeholder that is not known here")
    return template


def unpack(sdist, wheel, target):
    include = target / "include" / "OpenColorIO"
    include.mkdir(parents=True)
    (target / "lib").mkdir()
    prefix = f"opencolorio-{VERSION}/include/OpenColorIO/"
    with tarfile.open(sdist) as archive:
        for member in archive:
            if not member.isfile() or not member.name.startswith(prefix):
                continue
            name, text = member.name[len(prefix) :], archive.extractfile(member).read().decode()
            if name.endswith(".h"):
                (include / name).write_text(text)
            elif name == "OpenColorABI.h.in":
                (include / "OpenColorABI.h").write_text(abi_header(text))
    with zipfile.ZipFile(wheel) as archive:
        library = target / "lib" / "libOpenColorIO.so"
        library.write_bytes(archive.read("PyOpenColorIO/libOpenColorIO.so"))
        library.chmod(0o755)
        (target / "LICENSE").write_bytes(
            archive.read(f"opencolorio-{VERSION}.dist-info/licenses/LICENSE")
        )


def main(directory):
    place = pathlib.Path(directory)
    target, stamp = place / "ocio", place / "ocio" / ".version"
    if (
        stamp.exists()
        and stamp.read_text() == VERSION
        and (target / "lib" / "libOpenColorIO.so").exists()
    ):
        return
    if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        sys.exit(
            f"dependencies: no pinned OpenColorIO for {platform.system()} {platform.machine()}; "
            f"put version {VERSION} into {target}/include and {target}/lib"
        )
    cache = place / "cache"
    cache.mkdir(parents=True, exist_ok=True)
    print(f"dependencies: OpenColorIO {VERSION}", flush=True)
    index = Index(pip_config())
    sdist, wheel = index.fetch(*SDIST, cache), index.fetch(*WHEEL, cache)
    fresh = place / f"ocio.{os.getpid()}"
    shutil.rmtree(fresh, ignore_errors=True)
    unpack(sdist, wheel, fresh)
    (fresh / ".version").write_text(VERSION)
    shutil.rmtree(target, ignore_errors=True)
    fresh.rename(target)


if __name__ == "__main__":
    main(sys.argv[1])
