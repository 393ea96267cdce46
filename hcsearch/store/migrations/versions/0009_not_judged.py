"""Statuses of what was never judged: the stage `mobility` left `undecided` where no path had been looked for.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Keep what is proved; verdicts in scenes stand in tables of their own."""
    for table in ("design", "folding"):
        op.execute(f"UPDATE {table} SET status = NULL WHERE status = 'undecided'")
