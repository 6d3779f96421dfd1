from efficiency.app import serve_app as serve_app
from efficiency.axle.axle import Axle as Axle
from efficiency.blanks.pair import pair_blank
from efficiency.conditions.duty import DutyCycle as DutyCycle
from efficiency.conditions.grid import Grid as Grid
from efficiency.installation import examine
from efficiency.loss.efficiency_result import EfficiencyResult as EfficiencyResult
from efficiency.machine_settings.correction import machine_corrections as machine_corrections
from efficiency.machine_settings.solve import machine_settings
from efficiency.mesh import LoadedMesh as LoadedMesh
from efficiency.mesh import Mesh as Mesh
from efficiency.optimisation.load_sizing import sized_for_load as sized_for_load
from efficiency.optimisation.optimise import optimise as optimise
from efficiency.output.machine_summary import design_from_sheet
from efficiency.pair import GearPair as GearPair
from efficiency.pairs import cylindrical as cylindrical
from efficiency.pairs import load as load
from efficiency.studies.demonstration import run_demo
from efficiency.studies.parameter_study import run_study
from efficiency.templates import new_file as new_file
from efficiency.templates import new_questions as new_questions
from ehl.warmup import warm_up

__version__: str

blank = pair_blank
demo = run_demo
doctor = examine
import_design = design_from_sheet
settings = machine_settings
study = run_study
warmup = warm_up
