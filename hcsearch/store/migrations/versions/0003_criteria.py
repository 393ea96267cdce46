"""Criteria of designs, which the views work out (ratio, hinges, the folding that deploys): no table changes."""

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Leave the tables as they are."""
