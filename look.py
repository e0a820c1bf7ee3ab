import sys; sys.argv=["x","0.5"]
exec(open("/tmp/fitdraft/proto.py").read().split('if __name__')[0])
w=2.5
run=pc.simulate(pc.impact_oscillator(0.8,wall=0.2,side="above",damping=0.05),pc.cosine(w),0.,.5,periods=60)
im=run.impacts
for a,b in zip(im.t,im.v_before):
    if 98<a<105: print(a,b)
for tt in np.arange(99.5,103.2,.1): print("%.2f %.4f %.4f"%(tt,*[float(q) for q in run(tt)]))
