# Do a job
from hcsearch.api.billing import bill_of_materials as bill_of_materials
from hcsearch.api.building_atlas import build_atlas as build_atlas
from hcsearch.api.checking import check as check
from hcsearch.api.counting import count as count
from hcsearch.api.deploying import deploy as deploy
from hcsearch.api.describing import describe as describe
from hcsearch.api.driving import drive as drive
from hcsearch.api.enumerating import enumerate_into as enumerate_into
from hcsearch.api.exporting import save as save
from hcsearch.api.exporting import save_designs as save_designs
from hcsearch.api.following_motions import follow_motion as follow_motion
from hcsearch.api.identifying import identify_damping as identify_damping
from hcsearch.api.identifying import identify_motion as identify_motion
from hcsearch.api.identifying import identify_spring as identify_spring
from hcsearch.api.initializing import init_scene as init_scene
from hcsearch.api.measuring_accuracy import accuracy as accuracy
from hcsearch.api.measuring_accuracy import stability as stability
from hcsearch.api.proving import prove as prove
from hcsearch.api.proving import verify as verify
from hcsearch.api.querying import rank as rank
from hcsearch.api.querying import read as read
from hcsearch.api.replaying import replay as replay
from hcsearch.api.reporting import report as report
from hcsearch.api.reviewing import sheet as sheet
from hcsearch.api.searching_units import search_units as search_units
from hcsearch.api.serving import serve as serve
from hcsearch.api.showing import show as show
from hcsearch.api.showing import show_page as show_page
from hcsearch.api.tuning import tune as tune
from hcsearch.api.tuning import tune_to_rules as tune_to_rules

# What is meant by a name
from hcsearch.subjects.case import Case as Case
from hcsearch.subjects.resolve import resolve as resolve

# Arrays and circuits
from hcsearch.designs.grid import GRIDS as GRIDS
from hcsearch.designs.grid import Grid as Grid
from hcsearch.designs.grid import Array as Array
from hcsearch.designs.grid import parse_array as parse_array
from hcsearch.designs.circuit import Circuit as Circuit
from hcsearch.search.enumeration import enumerate_circuits as enumerate_circuits
from hcsearch.search.enumeration import count_array as count_array

# Searches as batches
from hcsearch.search.enumeration import PolygonSearch as PolygonSearch
from hcsearch.search.enumeration import ArraySearch as ArraySearch
from hcsearch.search.enumeration import ArrayCount as ArrayCount

# Foldings
from hcsearch.designs.folding import Folding as Folding
from hcsearch.designs.folding import foldings as foldings
from hcsearch.designs.twisting import twist as twist
from hcsearch.designs.twisting import gauss_linking as gauss_linking

# Panels in space
from hcsearch.shape.pattern import Pattern as Pattern
from hcsearch.shape.linkage import Linkage as Linkage
from hcsearch.scenes import Scene as Scene
from hcsearch.scenes import SCENES as SCENES

# Results
from hcsearch.export.bill_items import BillOfMaterials as BillOfMaterials
from hcsearch.web.atlas.atlas_files import Atlas as Atlas
from hcsearch.export.bulk_export import SavedDesigns as SavedDesigns
from hcsearch.springs.deployment.deployment_facts import Deployed as Deployed
from hcsearch.springs.tuning.spring_tuning import Tuning as Tuning
from hcsearch.springs.drive.drive_facts import Drive as Drive
from hcsearch.springs.flight.flight_sheet import FlightSheet as FlightSheet
from hcsearch.subjects.replay import Replay as Replay
from hcsearch.motion.paths.linkage_motion import LinkageMotion as LinkageMotion
from hcsearch.search.pipeline import Funnel as Funnel

# Databases
from hcsearch.store import open_database as open_database
from hcsearch.store import open_readonly as open_readonly
from hcsearch.store import select as select
from hcsearch.store import select_sql as select_sql

# Errors and version
from hcsearch.basics.errors import HcsearchError as HcsearchError
from hcsearch.system.machine import __version__ as __version__
