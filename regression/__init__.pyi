from regression.calibration.calibrate import calibrate as calibrate
from regression.data.dataset import Dataset as Dataset
from regression.data.dataset import load_dataset as load_dataset
from regression.formula import Formula as Formula
from regression.formula import fit as fit
from regression.formula import friction_model as friction_model
from regression.formula import published as published
from regression.plan.operating_range import OperatingRange as OperatingRange
from regression.plan.operating_range import WeightedPoints as WeightedPoints
from regression.plan.operating_range import operating_range as operating_range
from regression.plan.plan import Plan as Plan
from regression.sweeping.run import Run as Run
from regression.sweeping.run import sweep as sweep
from regression.sweeping.slurm import slurm_script as slurm_script

__version__: str
