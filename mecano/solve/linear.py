import scipy.sparse as sp
import scipy.sparse.linalg as sla


class St:
    singular=False
class LinearSolver:
    def __init__(s,n,rows,cols,groups,n_q): s.n,s.rows,s.cols=n,rows,cols
    def solve(s,data,b,x):
        st=St(); A=sp.csc_matrix((data[:len(s.rows)],(s.rows,s.cols)),shape=(s.n,s.n))
        try: s.lu=sla.splu(A)
        except RuntimeError: st.singular=True; return st
        x[:]=s.lu.solve(b); return st
    def resolve(s,b,x): x[:]=s.lu.solve(b)
