"""Requests that nobody sends in good faith: each is refused or answered harmlessly, and nothing changes."""

import functools
import gc
import hashlib
import html
import re
import tracemalloc

import pytest

pytestmark = pytest.mark.extra

MARK = "<script>alert(1)</script>"
QUOTED = "%3Cscript%3Ealert(1)%3C/script%3E"
HUGE = "9" * 60

PATHS = [
    *("/..", "/../..", "/../../etc/passwd", "/static/../../etc/passwd", "/static/x/../../../etc/passwd"),
    *("/static/", "/static/x", "/static/x/", "/static/x/serve.js", "/static/x/report.html", "/static/x/..%2f..%2fx"),
    *("//", "//designs", "///etc/passwd", "/designs//1", "/designs/1/", "/designs/../etc/passwd", "/./designs"),
    *("/etc/passwd", "/designs.sqlite", "/hcsearch.sqlite", "/designs.sqlite-wal", "/.git/config", "/.env"),
    *("/designs.csv/..", "/designs.json.csv", "/designs.parquet", "/designs.txt", "/designs.CSV", "/Designs"),
    *("/designs/0", "/designs/-1", "/designs/1.5", "/designs/1e3", "/designs/0x1", "/designs/1;2", "/designs/one"),
    *(f"/designs/{HUGE}", f"/designs/{2**63}", f"/designs/{2**64 + 1}", "/designs/" + "1" * 400),
    *("/designs/1'--", "/designs/1 OR 1=1", "/designs/1/*", "/designs/1;DROP TABLE design", '/designs/1"'),
    *(f"/designs/{MARK}", f"/{MARK}", f"/designs.csv{MARK}", f"/static/x/{MARK}", f"/designs/1/{MARK}"),
    *("/designs/1/foldings", "/designs/1/foldings/0", "/designs/1/foldings/x/export.fold", "/designs/1/export."),
    *("/designs/1/export", "/designs/1/export.exe", "/designs/1/export.../../x", "/designs/1/export.py"),
    *("/designs/1/export.fold", "/designs/1/foldings/0/export.toml", f"/designs/1/foldings/{HUGE}/export.exe"),
    *(f"/designs/{HUGE}/foldings/1/export.fold", f"/designs/{HUGE}/export.g6", "/designs/1/foldings/-1/export.fold"),
    *("/\x00", "/designs\x00", "/designs/1\x00.csv", "/designs\r\nSet-Cookie: a=b", "/designs\n", "/\r\n\r\n"),
    *("/\xff\xfe", "/designs/\xc3\x28", "/\xc0\xae\xc0\xae/etc/passwd", "/\xed\xa0\x80", "/designs/\xf0\x9f\x98\x80"),
    *("/%2e%2e/etc/passwd", "/%00", "/%", "/%zz", "/designs%2f1", "\\..\\..\\windows\\win.ini", "designs", "", "*"),
    *("/design", "/outcome", "/sqlite_schema", "/hcsearch_version", "/batch", "/admin", "/console", "/server-status"),
    *("/" + "a" * 600, "/" + "a/" * 300, "/designs/" + "../" * 200, "http://evil.example/designs", "/-/json"),
]
QUERIES = [
    *("q='", "q=%27%20OR%201=1--", "q=id=1;DROP TABLE design", "q=id=1)%20OR%20(1=1", "q=1=1", "q=id=1--"),
    *("q=grid=%27%20OR%201=1", "q=id%20IN%20(SELECT%20id)", "q=UNION%20SELECT", "q=id=(SELECT%201)", "q=id=0x1"),
    *(
        "q=untwisted;ATTACH",
        "q=PRAGMA%20x=1",
        "q=id=load_extension(1)",
        "q=sqlite_schema",
        "q=rowid=1",
        "q=design.id=1",
    ),
    *(
        f"q={QUOTED}",
        f"q=array={QUOTED}",
        f"q=circuit={QUOTED}",
        f"q=grid={QUOTED}",
        f"sort={QUOTED}",
        f"page={QUOTED}",
    ),
    *(
        f"as={QUOTED}",
        f"scene={QUOTED}",
        f"{QUOTED}=1",
        "q=%22%3E%3Cimg%20src=x%20onerror=alert(1)%3E",
        "q=%22onfocus=%22",
    ),
    *("q=javascript:alert(1)", "scene=%22%3E%3Cscript%3E", "sort=%22onmouseover=alert(1)", "q=%7B%7B7*7%7D%7D=1"),
    *(f"page={HUGE}", "page=0", "page=-1", "page=1.5", "page=1e9", "page=%D9%A3", "page=0x10", "page=1;2", "page=NaN"),
    *(f"q=id={HUGE}x", "q=id=1e", "q=dof<=nan", "q=dof<=inf", "q=n=", "q=n==", "q=n=<", "q==", "q=<>", "q=id"),
    *("q=array=@/etc/passwd", "q=array=@/dev/zero", "q=not%20array=@../x", "q=(array!=@/etc/hosts)", "q=circuit=@/x"),
    *("q=array=9999x9999", "q=array=t99999999", "q=array=h1000", "q=array=p999x999", "q=array=" + "9-" * 500 + "9"),
    *("array=120x120", "array=hex:6.7.7,t99"),
    *("q=" + "a" * 2001, "q=" + "x" * 9000, "q=" + "(" * 200, "q=" + "not%20" * 50 + "untwisted", "q=" + ")" * 50),
    *("q=" + "+".join(["array=6x5"] * 11), "q=" + "+".join(["n=1"] * 501), "q=or", "q=not", "q=and%20or", "q=()"),
    *("q=untwisted&q=two_stack", "page=1&page=2", "sql=SELECT%201", "db=/etc/passwd", "debug=1", "_method=DELETE"),
    *(
        "sort=-",
        "sort=--id",
        "sort=id;DROP",
        "sort=nothing",
        "sort=" + "id," * 100,
        "sort=random()",
        "sort=1",
        "as=html",
    ),
    *("q=%FF%FE", "q=%C3%28", "q=%ED%A0%80", "q=%00", "q=n=10%00", "q=%0D%0ASet-Cookie:a=b", "q=%1B[2J", "scene=%00"),
    *("scene=../../etc/passwd", "scene=/etc/passwd.toml", "scene=x.toml", "scene=" + "s" * 300, "scene=earth"),
    *("scene=default,solar.toml", "scene=default,50x50", "columns=nothing", "limit=-1", "limit=1e99", "limit=x"),
    *("columns=%27", f"columns={QUOTED}", "limit=" + HUGE, "q=%F0%9F%98%80", "q=id=%E2%80%AE1", "%=%", "&&&=&", "q"),
]
EXPORTS = [
    *("format=../x", "format=fold&format=glb", "motion=../x", "state=nan", "state=2", "kerf_mm=1e99", "kerf_mm=nan"),
    *("part=" + "p" * 100, "scene=x.toml", "scene=/etc/passwd", "output=/tmp/x", "stem=../../x", f"part={QUOTED}"),
    *("timestep_s=0x1", "contact=yes", "profile=x", "sheet=x", "db=/etc/passwd"),
]
METHODS = ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "PROPFIND", "get", "DROP", "", "GET "]
HOSTS = [
    *(
        "evil.example",
        "evil.example:8000",
        "127.0.0.1.evil.example",
        "localhost.evil.example",
        "127.0.0.1@evil.example",
    ),
    *("", "localhost:", "localhost:x", "localhost:999999", "127.0.0.1:8000, evil.example", "[::1", "[evil.example]"),
    *(
        "0.0.0.0",
        "127.0.0.2",
        "10.0.0.1:8000",
        MARK,
        "localhost\r\nX: y",
        "локалхост",
        "127.1",
        "2130706433",
        "a" * 300,
    ),
]


def harmless(answer, address):
    assert 200 <= answer.status < 500, (address, answer.status)
    assert answer.status in (200, 302) or answer.status >= 400
    text = answer.body.decode()
    kind = answer.headers["Content-Type"]
    if kind.startswith("text/html"):
        for script in re.findall("<script.*?>", text):
            assert re.fullmatch(
                '<script (type="application/json" id="data"|src="/static/[0-9a-f]{16}/[a-z]+.js")>', script
            )
        assert not re.search(r"<img|\son\w+\s*=\s*[^ ]*alert\(1\)[^&<]*>", text)
    else:
        assert kind.startswith(("text/csv", "application/json", "text/css", "text/javascript", "text/plain"))
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert "Set-Cookie" not in answer.headers
    assert "root:" not in text
    assert "Traceback" not in text


def fingerprint(path):
    """What is in the files of the folder; a reader of SQLite leaves an empty log, and memory that it shares."""
    files = {file.name: file.read_bytes() for file in path.parent.iterdir() if not file.name.endswith("-shm")}
    return {name: hashlib.sha256(content).hexdigest() for name, content in files.items() if content}


def test_hostile_requests_are_refused_or_answered_harmlessly(asking, database_file, number, capsys):
    before, asked = fingerprint(database_file), 0

    def ask(address, *more, refused=False, **environ):
        nonlocal asked
        asked += 1
        answer = asking(address, *more, **environ)
        harmless(answer, address)
        assert not refused or answer.status >= 400, address

    for path in PATHS:
        ask(path, refused=True)
    for query in QUERIES:
        for address in ("/designs", "/designs.json"):
            ask(f"{address}?{query}")
    for query in EXPORTS:
        ask(f"/designs/{number}/foldings/1/export.fold?{query}", refused=True)
    for method in METHODS:
        ask("/designs", method, refused=True)
    for host in HOSTS:
        ask("/designs", HTTP_HOST=host, refused=True)
    for site in ("cross-site", "same-site"):
        ask("/designs.json", HTTP_SEC_FETCH_SITE=site, HTTP_SEC_FETCH_MODE="no-cors", refused=True)
    assert asked > 200
    assert capsys.readouterr().err == ""  # where faults of the program are written
    assert fingerprint(database_file) == before
    assert asking("/designs").status == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site", "same-origin", "none"])
@pytest.mark.parametrize("kind", ["iframe", "frame", "fencedframe", "embed", "object"])
def test_no_frame_is_answered(asking, number, monkeypatch, site, kind):
    monkeypatch.setattr(asking.application, "computing", None)  # which nothing comes to
    said = {"HTTP_SEC_FETCH_SITE": site, "HTTP_SEC_FETCH_MODE": "navigate", "HTTP_SEC_FETCH_DEST": kind}
    for address in (f"/designs/{number}", f"/designs/{number}/export.g6", "/designs"):
        assert asking(address, **said).status == 403


@pytest.mark.parametrize(
    ("site", "mode", "purpose", "status"),
    [
        ("cross-site", "navigate", "", 200),
        ("none", "navigate", "", 200),
        ("none", "navigate", "prefetch", 200),
        ("same-origin", "no-cors", "prefetch", 200),
        ("cross-site", "navigate", "prefetch", 403),
        ("same-site", "navigate", "prefetch;prerender", 403),
        ("cross-site", "no-cors", "", 403),
        ("cross-site", "cors", "", 403),
        ("cross-site", "websocket", "", 403),
    ],
)
def test_links_lead_here_and_nothing_else_of_another_site(asking, site, mode, purpose, status):
    said = {"HTTP_SEC_FETCH_SITE": site, "HTTP_SEC_FETCH_MODE": mode, "HTTP_SEC_FETCH_DEST": "document"}
    assert asking("/designs.json?limit=1", HTTP_SEC_PURPOSE=purpose, **said).status == status


@pytest.mark.parametrize(
    "address",
    ["/designs.csv?scene=x{}", "/motions.json?scene=x{}", "/foldings?scene=x{}", "/designs?q=x{}=1", "/designs/{}0000"],
)
def test_refused_requests_leave_nothing_in_memory(asking, address):
    def ask(numbers):
        for k in numbers:
            assert asking(address.format(k)).status in (400, 404)
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        before = ask(range(1000, 1050))
        assert ask(range(2000, 2100)) - before < 100_000  # what is kept of scenes has 30 kB each
    finally:
        tracemalloc.stop()


def caches():
    """How much each cache of the program holds, by name."""
    kind = type(functools.cache(len))
    # by type alone: to ask more of a weak reference whose object is gone is an error
    found = [one for one in gc.get_objects() if type(one) is kind]
    own = [one for one in found if str(one.__module__).startswith("hcsearch")]
    return {f"{one.__module__}.{one.__qualname__}": one.cache_info().currsize for one in own}


REFUSED = [
    *("/designs.csv?scene=x{}", "/designs.json?scene=x{}", "/designs?scene=x{}", "/foldings?scene=x{}"),
    *("/deployments.json?scene=x{}", "/designs?q=x{}=1", "/designs.csv?q=array={}x{}x", "/designs?sort=x{}"),
    *("/designs.csv?columns=x{}", "/designs.csv?scene=x{}&page=1", "/designs/1?scene=x{}", "/designs/{}0000"),
    *("/designs/{}0000/foldings/1/motion.json", "/designs/1/export.g6?scene=x{}", "/x{}", "/designs?page=x{}"),
]


def test_no_cache_keeps_what_was_refused(asking):
    from hcsearch.store.conditions import view_table

    def ask(numbers):
        for address in REFUSED:
            for k in numbers:
                assert asking(address.format(k, k)).status in (400, 404), address

    ask([100])  # what is made once
    kept = asking.application._counts._cache, asking.application.computing._cache
    before = caches(), [len(one._values) for one in kept], view_table.cache_info().currsize
    assert before[0]
    ask(range(101, 111))
    assert (caches(), [len(one._values) for one in kept], view_table.cache_info().currsize) == before


def test_what_is_asked_is_shown_as_text(asking):
    answer = asking(f"/designs?q=array={QUOTED}")
    assert answer.status == 400
    assert MARK in html.unescape(answer.text)
    assert MARK not in answer.text


def test_a_query_reads_no_file(asking, tmp_path):
    secret = tmp_path / "cells"
    secret.write_text("0 0\n1 0\n", encoding="ascii")
    answer = asking(f"/designs?q=array=@{secret}")
    assert (answer.status, "files are not read here" in answer.text) == (400, True)


@pytest.mark.parametrize(
    ("host", "header", "known"),
    [
        ("127.0.0.1", "localhost", True),
        ("127.0.0.1", "LOCALHOST.:8000", True),
        ("127.0.0.1", "[::1]:8000", True),
        ("designs.example", "designs.example:80", True),
        ("127.0.0.1", "designs.example", False),
        ("0.0.0.0", "192.168.0.7:8000", True),
        ("0.0.0.0", "designs.example", False),
    ],
)
def test_names_by_which_the_page_is_known(host, header, known):
    from hcsearch.web.serve.requests import is_known_host

    assert is_known_host(header, host) is known
