from ehl.common.data import shipped as shipped
from ehl.common.errors import ConvergenceError as ConvergenceError
from ehl.common.errors import InputError as InputError
from ehl.common.errors import MixedEhlError as MixedEhlError
from ehl.common.quantities import Quantity as Quantity
from ehl.common.quantities import quantity as quantity
from ehl.common.table import Table as Table
from ehl.contact import Contact as Contact
from ehl.fluid.lubricant import Lubricant as Lubricant
from ehl.fluid.oil import Oil as Oil
from ehl.material import Material as Material
from ehl.result import ContactResult as ContactResult
from ehl.sequence import PathResult as PathResult
from ehl.sequence import solve_path as solve_path
from ehl.state import ContactState as ContactState
from ehl.surface.finish import Finish as Finish
from ehl.surface.measured_surface import MeasuredSurface as MeasuredSurface
from ehl.surface.measured_surface import measured_surface as measured_surface

SOLVER: str
__version__: str
