from test_tie_order import *
def test_x():
    for basis in ("linear","dual"):
        e=[tied("tetrahedron",2,n,basis) for n in (2,3,4,6)]
        print(basis,e,np.log(np.array(e[:-1])/e[1:])/np.log([1.5,4/3,1.5]))
