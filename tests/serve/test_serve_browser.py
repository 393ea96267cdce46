"""The pages in a real browser, as a reader goes through them."""

import json

import pytest

from tests.player.browser import chromium

pytestmark = pytest.mark.extra

PLAYER = "document.querySelector('.player > div').shadowRoot"

DIALOG_PLAYER = "document.querySelector('dialog .player > :not(.moves)')?.shadowRoot"


def test_filter_sort_open_play_and_download(address, number, tmp_path):
    (tmp_path / "files").mkdir()
    with chromium(tmp_path / "profile") as tab:
        tab.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path / "files"))
        tab.open(f"{address}/")
        assert tab.value("document.querySelectorAll('.gallery .card .thumb svg').length") == 48
        tab.value("document.querySelector('[rel=next]').click()")
        tab.until("location.search === '?page=2' && document.querySelectorAll('.card').length === 48")
        tab.value("document.querySelector('[name=q]').value = 'untwistd n_foldings>=3'")
        tab.value("document.querySelector('form.tools').requestSubmit()")
        tab.until("document.getElementById('wrong').textContent.includes('did you mean untwisted')")
        assert tab.value("document.querySelectorAll('.gallery .card').length") == 48  # the rows stay
        assert tab.value("document.getElementById('working').hidden")
        tab.events = [event for event in tab.events if event.get("method") != "Log.entryAdded"]  # the refusal
        tab.value("document.querySelector('[name=q]').value = 'untwisted n_foldings>=3'")
        tab.value("document.querySelector('form.tools').requestSubmit()")
        tab.until("location.search.startsWith('?q=untwisted') && !!document.querySelector('.card h3')")
        tab.value("document.querySelector('[name=sort]').value = '-id'")
        tab.value("document.querySelector('[name=sort]').dispatchEvent(new Event('change'))")
        tab.until("location.search.endsWith('sort=-id') && !!document.querySelector('.card h3')")
        shown = tab.value(
            "[...document.querySelectorAll('.card h3 a')].map((link) => Number(link.textContent.slice(1)))"
        )
        assert shown == sorted(shown, reverse=True)
        assert number in shown
        card = f"document.querySelector('.card h3 a[href=\"/designs/{number}\"]').closest('.card')"
        tab.value(f"{card}.querySelector('.thumb').click()")
        assert tab.value("document.querySelector('dialog').open")
        tab.until(f"!!{DIALOG_PLAYER}?.querySelector('button.go')")
        tab.value(f"{DIALOG_PLAYER}.querySelector('button.go').click()")
        tab.until(f"Number({DIALOG_PLAYER}.querySelector('input[type=range]').value) > 0")
        tab.value("document.querySelector('dialog header a').click()")
        tab.until(f"location.pathname === '/designs/{number}' && document.readyState === 'complete'")
        tab.value("document.querySelector('.player').scrollIntoView()")
        tab.until("!!document.querySelector('.player > div')")
        play = f"{PLAYER}.querySelector('button.go')"
        tab.value(f"{play}.click()")
        slider = f"Number({PLAYER}.querySelector('input[type=range]').value)"
        tab.until(f"{slider} > 0")
        tab.value(
            "[...document.querySelectorAll('.links a[download]')].find((link) => link.textContent === 'glb').click()"
        )
        file = tmp_path / "files" / f"design-{number}-folding-1.glb"
        for _ in range(600):
            if file.exists():
                break
            tab.value("new Promise((done) => setTimeout(done, 50))")
        assert file.read_bytes()[:4] == b"glTF"
        assert tab.complaints == []
        assert all(request.startswith(address) for request in tab.requests), json.dumps(tab.requests)


def test_the_note_on_a_page_to_come_goes_away_with_escape_and_does_not_come_for_files(address, tmp_path):
    hidden = "document.getElementById('working').hidden"
    with chromium(tmp_path / "profile") as tab:
        tab.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        tab.open(f"{address}/designs?q=id<60")
        tab.value("document.addEventListener('click', (event) => event.preventDefault(), { once: true })")
        tab.value("document.querySelector('[rel=next]').click()")
        assert not tab.value(hidden)
        tab.press("Escape")
        assert tab.value(hidden)
        for ending in ("csv", "json"):
            tab.value(f"document.querySelector('.around a[href*=\".{ending}\"]').click()")
            assert tab.value(hidden)
        assert tab.complaints == []


def test_print_shows_all_columns_of_a_table_with_their_names(address, tmp_path):
    cells = "[...document.querySelectorAll('.rows tbody :is(td, th)')]"
    heads = "[...document.querySelectorAll('.rows thead th')].slice(1)"
    with chromium(tmp_path / "profile") as tab:
        tab.call("Emulation.setEmulatedMedia", media="print")
        # a landscape page of letter paper with the margins of Chromium
        tab.call("Emulation.setDeviceMetricsOverride", width=980, height=740, deviceScaleFactor=1, mobile=False)
        columns = "id,array,circuit,grid,n,status,symmetry,min_clearance,deploy_time,deployment_ratio"
        for path, as_blocks in (("designs?as=table", True), (f"designs?as=table&columns={columns}", False)):
            tab.open(f"{address}/{path}")
            assert tab.value(f"Math.max(...{cells}.map((cell) => cell.getBoundingClientRect().right))") <= 980
            assert (tab.value("document.querySelector('.rows thead').offsetHeight") == 0) == as_blocks
            unnamed = f"{cells}.filter((cell) => getComputedStyle(cell, '::before').content === 'none').length"
            count = tab.value("document.querySelectorAll('.rows tbody tr').length")
            assert tab.value(unnamed) == (count if as_blocks else tab.value(f"{cells}.length"))
            named = (
                "[...document.querySelectorAll('.rows tbody tr')[0].cells].slice(1).map((cell) => cell.dataset.name)"
            )
            words = "((head) => [head.querySelector('a').textContent, head.querySelector('small')?.textContent])"
            title = f"{heads}.map({words}).map((both) => both.filter(Boolean).join(', '))"
            assert tab.value(named) == tab.value(title)
