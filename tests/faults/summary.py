"""The table that says, after a test session, which faults were injected and what was lost."""

PROPERTY = "fault"


def pytest_terminal_summary(terminalreporter):
    """One line a kind of fault, over all tests and, under xdist, all workers."""
    kinds = {}
    for outcome in ("passed", "failed"):
        for report in terminalreporter.getreports(outcome):
            for name, value in report.user_properties:
                if name == PROPERTY and report.when == "call":
                    sums = kinds.get(value[0], (0, 0, 0))
                    kinds[value[0]] = [sum(pair) for pair in zip(sums, value[1:], strict=True)]
    if not kinds:
        return
    terminalreporter.section("faults")
    terminalreporter.write_line(f"{'kind':32}{'injected':>10}{'finished batches before':>26}{'rows lost':>12}")
    for kind, (injected, finished, lost) in sorted(kinds.items()):
        terminalreporter.write_line(f"{kind:32}{injected:10}{finished:26}{lost:12}")
