"""The database: its schema and upgrades, recording finished work, and queries. The only home of SQLAlchemy and Alembic.

The names below are looked up on first use, so that reading `hcsearch.store.columns` (for --help) costs no SQLAlchemy.
"""

from hcsearch.system.lazy import lazy_importer

__getattr__ = lazy_importer(__name__)
